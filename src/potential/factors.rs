//! What one instance's tissue has differently from its avatar's, to be changed while it runs.

use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// Factors on the tissue of one instance, 1 by default; other values need no bake and cost nothing. They hold from one
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
}

impl Default for TissueFactors {
    fn default() -> Self {
        Self {
            stiffness: 1.0,
            damping: 1.0,
            gravity: 1.0,
            friction: 1.0,
        }
    }
}

impl TissueFactors {
    /// Checks the numbers.
    ///
    /// # Errors
    /// [`Error::Invalid`] names the factor that is negative or not finite, or a stiffness that is zero.
    pub fn validate(&self) -> Result<()> {
        let Self {
            stiffness,
            damping,
            gravity,
            friction,
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
        Ok(())
    }
}
