//! What one instance's tissue has differently from its avatar's, to be changed while it runs.

use crate::material::{DEFAULT_BOUNCE, LocalTissue, damping_ratio};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// T: how many times as stiff as when relaxed a muscle is when it is tense. Its frequency grows by √8 then: the 6 Hz of a thigh
/// become 17 Hz, of the 12 to 20 Hz that are measured.
const TENSE_STIFFNESS: f64 = 8.0;

/// Factors on the tissue of one instance, 1 by default (tension 0); other values need no bake and cost nothing. They hold from one
/// step to the next, and may differ in each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct TissueFactors {
    /// On the elastic energy, and so on stress and tangent and on the damping that is proportional to it; positive.
    pub stiffness: f64,
    /// On the damping time β, besides; not negative.
    pub damping: f64,
    /// On gravity as the tissue feels it; not negative.
    pub gravity: f64,
    /// On μ of all contacts; not negative.
    pub friction: f64,
    /// How tense muscles are, 0 (relaxed) to 1: tissue that is a share m of muscle ([`LocalTissue::muscle`]) is
    /// 1 + 7 m `tension` times as stiff. Its damping time falls with the root of that, so that its damping ratio stays.
    pub tension: f64,
}

impl Default for TissueFactors {
    fn default() -> Self {
        Self {
            stiffness: 1.0,
            damping: 1.0,
            gravity: 1.0,
            friction: 1.0,
            tension: 0.0,
        }
    }
}

impl TissueFactors {
    /// Factors that are all as by default, but for the damping: see [`TissueFactors::set_bounce`].
    ///
    /// # Errors
    /// As [`TissueFactors::set_bounce`].
    pub fn with_bounce(bounce: f64) -> Result<Self> {
        let mut factors = Self::default();
        factors.set_bounce(bounce)?;
        Ok(factors)
    }

    /// Sets `damping` so that tissue which was baked with [`DEFAULT_BOUNCE`] has this one: from 0 (it creeps back) by 0.5 (it
    /// swings some five times) to 1 (for long). Tissue with another bounce keeps its ratio to the default's.
    ///
    /// # Errors
    /// [`Error::Invalid`] names `factors.bounce` where it is not in 0..=1.
    pub fn set_bounce(&mut self, bounce: f64) -> Result<()> {
        check_share("factors.bounce", bounce, "the tissue is baked with 0.5")?;
        self.damping = damping_ratio(bounce) / damping_ratio(DEFAULT_BOUNCE);
        Ok(())
    }

    /// (T − 1) τ with the tension τ: times the share of muscle what tension adds to 1.
    pub(crate) fn added_by_tension(&self) -> f64 {
        (TENSE_STIFFNESS - 1.0) * self.tension
    }

    /// What a point has of its own, with the factors on stiffness and with tension: both the stiffness and, since
    /// ζ = ω β/2 and ω goes with the root of the stiffness, β.
    pub(crate) fn on(&self, local: LocalTissue) -> LocalTissue {
        let tense = 1.0 + self.added_by_tension() * local.muscle;
        LocalTissue {
            stiffness: local.stiffness * self.stiffness * tense,
            damping_time: local.damping_time / tense.sqrt(),
            ..local
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// [`Error::Invalid`] names the factor that is negative or not finite, a stiffness that is zero, or a tension outside 0..=1.
    pub fn validate(&self) -> Result<()> {
        let Self {
            stiffness,
            damping,
            gravity,
            friction,
            tension,
        } = *self;
        if !(stiffness > 0.0 && stiffness.is_finite()) {
            let problem =
                format!("{stiffness}; must be positive and finite (1 leaves the tissue as it is)");
            return Err(Error::invalid("factors.stiffness", problem));
        }
        for (field, factor) in [
            ("factors.damping", damping),
            ("factors.gravity", gravity),
            ("factors.friction", friction),
        ] {
            if !(factor >= 0.0 && factor.is_finite()) {
                let problem = format!(
                    "{factor}; must be finite and not negative (1 leaves the tissue as it is)"
                );
                return Err(Error::invalid(field, problem));
            }
        }
        check_share("factors.tension", tension, "0 is relaxed, 1 tense")
    }
}

/// That a value is in 0..=1.
fn check_share(field: &str, value: f64, meaning: &str) -> Result<()> {
    if (0.0..=1.0).contains(&value) {
        return Ok(());
    }
    let problem = format!("{value}; must be in 0..=1 ({meaning})");
    Err(Error::invalid(field, problem))
}
