//! What a bake says of a region's softness.

use serde::{Deserialize, Serialize};
use std::fmt;

/// How soft a region is.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RegionReport {
    /// A part of a person, what a recipe selects, or what is left ("elsewhere"; "tissue" where there is nothing else).
    pub name: String,
    /// Whether the bake chose its modulus.
    pub chosen: bool,
    /// Shear modulus G of small strains, Pa, before a recipe's stiffness regions.
    pub shear_modulus: f64,
    /// Frequency f₁ of its sway in the reduced tissue, Hz; 0 where nothing of it moves.
    pub frequency: f64,
    /// Depth of its tissue, which 15 % of its skin's area exceed, m.
    pub depth: f64,
    /// Damping ratio ζ at that frequency.
    pub damping_ratio: f64,
    /// Part of it that is muscle, 0 to 1.
    pub muscle: f64,
    /// Mass of its tissue, kg.
    pub mass: f64,
}

impl fmt::Display for RegionReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "G {:.0} Pa{}, f₁ {:.1} Hz, ζ {:.2}, {:.0} mm deep, {:.2} kg",
            self.shear_modulus,
            if self.chosen { " (chosen)" } else { "" },
            self.frequency,
            self.damping_ratio,
            1e3 * self.depth,
            self.mass
        )?;
        match self.muscle > 0.0 {
            true => write!(f, ", {:.0} % muscle", 100.0 * self.muscle),
            false => Ok(()),
        }
    }
}
