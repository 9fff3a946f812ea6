//! How far a joint turns.

use crate::{Error, Result};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// How far a bone may turn relative to its parent, R_pᵀR_j, from the bind pose; rad.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum JointRange {
    /// A box of rotation vectors.
    Axes {
        /// Columns: the axes of the box in the bind pose; a rotation.
        axes: DMat3,
        /// Least angle about each.
        least: DVec3,
        /// Most angle about each.
        most: DVec3,
    },
    /// A cone about a direction, and a range of twist about it.
    Cone {
        /// The direction in the bind pose, along the bone as a rule; a unit vector.
        axis: DVec3,
        /// Most angle between the direction and where it was.
        swing: f64,
        /// Least and most twist about it.
        twist: [f64; 2],
    },
}

impl JointRange {
    /// Checks every number; `field` names the range in errors.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub fn validate(&self, field: &str) -> Result<()> {
        let check = |ok: bool, problem: &str| match ok {
            true => Ok(()),
            false => Err(Error::invalid(field, problem)),
        };
        let range = |least: f64, most: f64| (-PI..=most).contains(&least) && most <= PI;
        match self {
            Self::Axes { axes, least, most } => {
                let skewness = (axes.transpose() * *axes - DMat3::IDENTITY).to_cols_array();
                let turned = skewness.iter().all(|s| s.abs() < 1e-6) && axes.determinant() > 0.0;
                check(turned, "its axes are no right-handed frame")?;
                let sound = (0..3).all(|k| range(least[k], most[k]));
                check(sound, "needs −180° ≤ least ≤ most ≤ 180° about each axis")
            }
            Self::Cone { axis, swing, twist } => {
                check(
                    (axis.length() - 1.0).abs() < 1e-6,
                    "its axis is no direction",
                )?;
                let sound = (0.0..=PI).contains(swing) && range(twist[0], twist[1]);
                check(
                    sound,
                    "needs a swing of 0 to 180° and −180° ≤ twist ≤ 180°, least first",
                )
            }
        }
    }
}
