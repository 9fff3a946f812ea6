//! What a recipe says of a region's softness.

use super::BodyRegion;
use serde::{Deserialize, Serialize};
use supple::{Error, Result};

/// How soft a region is: by the frequency of its first mode or by its shear modulus, and how long it rings. The region is what
/// satisfies every key that is given; where it does so in part, moduli blend as powers of the share. A later region goes before
/// those that it overlaps.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SoftnessRegion {
    /// A part of a person, which the bones' names and places tell; it goes in place of what the bake chooses for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub part: Option<BodyRegion>,
    /// Only what follows these bones: the share is the sum of their skin weights. None named: everything.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bones: Vec<String>,
    /// Only inside this box: lowest and highest corner in the reference shape, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub within: Option<[[f64; 3]; 2]>,
    /// The share is the body's map of this name ([`crate::Body::painted`]), carried into the depth.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub painted: Option<String>,
    /// Frequency of its sway in the reduced tissue, Hz: the modulus is scaled to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub f1: Option<f64>,
    /// Shear modulus G of small strains, Pa; without it and `f1` the region is as soft as it would be.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shear_modulus: Option<f64>,
    /// How long it swings, from 0 (not at all: ζ = 1) to 1 (ζ = 0.03); the recipe's own where none is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bounce: Option<f64>,
}

impl SoftnessRegion {
    /// Checks the numbers; `field` names the region in errors.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the key.
    pub fn validate(&self, field: &str) -> Result<()> {
        for (key, value, unit) in [
            ("f1", self.f1, "Hz"),
            ("shear_modulus", self.shear_modulus, "Pa"),
        ] {
            if let Some(value) = value.filter(|v| !(*v > 0.0 && v.is_finite())) {
                let problem = format!("must be positive ({unit}), is {value}");
                return Err(Error::invalid(format!("{field}.{key}"), problem));
            }
        }
        if self.f1.is_some() && self.shear_modulus.is_some() {
            let problem = "follows from shear_modulus: leave one of the two out";
            return Err(Error::invalid(format!("{field}.f1"), problem));
        }
        if self.f1.is_none() && self.shear_modulus.is_none() && self.bounce.is_none() {
            let problem = "says nothing: give it f1 (Hz), shear_modulus (Pa) or bounce";
            return Err(Error::invalid(field, problem));
        }
        check_bounce(self.bounce, &format!("{field}.bounce"))
    }

    /// Whether it names where it is besides a part of a person.
    pub(crate) fn is_selected(&self) -> bool {
        !self.bones.is_empty() || self.within.is_some() || self.painted.is_some()
    }

    /// What reports call it.
    pub(crate) fn name(&self) -> String {
        let part = self.part.map(|part| part.name().to_string());
        let own = [part, self.painted.clone()].into_iter().flatten();
        let mut words: Vec<String> = own.chain(self.bones.iter().cloned()).collect();
        if self.within.is_some() {
            words.push("box".into());
        }
        match words.is_empty() {
            true => "tissue".into(),
            false => words.join(", "),
        }
    }
}

/// That a bounce is in 0..=1.
pub(crate) fn check_bounce(bounce: Option<f64>, field: &str) -> Result<()> {
    match bounce.filter(|b| !(0.0..=1.0).contains(b)) {
        None => Ok(()),
        Some(bounce) => {
            let problem =
                format!("must be from 0 (it creeps back) to 1 (it swings for long), is {bounce}");
            Err(Error::invalid(field, problem))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bad_numbers_name_their_key() {
        let error = |text: &str| {
            let region: SoftnessRegion = toml::from_str(text).unwrap();
            region.validate("softness[2]").unwrap_err().to_string()
        };
        for (text, key) in [
            ("f1 = 0.0", "softness[2].f1"),
            ("f1 = -4.0", "softness[2].f1"),
            ("f1 = nan", "softness[2].f1"),
            ("shear_modulus = -1.0", "softness[2].shear_modulus"),
            ("shear_modulus = inf", "softness[2].shear_modulus"),
            ("bounce = 1.1", "softness[2].bounce"),
            ("bounce = -0.1", "softness[2].bounce"),
            ("bounce = nan", "softness[2].bounce"),
            ("f1 = 4.0\nshear_modulus = 300.0", "softness[2].f1"),
            ("part = \"breast\"", "softness[2]"),
        ] {
            let error = error(text);
            assert!(error.contains(key), "{text}: {error}");
        }
        assert!(toml::from_str::<SoftnessRegion>("part = \"wing\"").is_err());
        let fine: SoftnessRegion =
            toml::from_str("part = \"belly\"\nf1 = 4.5\nbounce = 0.0").unwrap();
        fine.validate("softness[0]").unwrap();
    }
}
