//! Mass and second moments of solids of even density.

use super::Shape;
use crate::model::BoneMass;
use crate::{Error, Result};
use glam::DVec3;
use std::f64::consts::PI;

impl Shape {
    /// Second moments about the shape's own origin, for a `density` in kg/m³.
    ///
    /// # Errors
    /// [`Error::Invalid`] of a half-space: it has no mass.
    pub fn mass(&self, density: f64) -> Result<BoneMass> {
        Ok(match *self {
            Self::HalfSpace => return Err(no_solid()),
            Self::Mesh(ref mesh) => {
                BoneMass::of_surface(mesh.grid().surface(), DVec3::ZERO, density)
            }
            Self::Sphere { radius } => ball(radius, density),
            // Across a disc ⟨x²⟩ = r²/4, along the axis ⟨z²⟩ = l²/3.
            Self::Cylinder {
                radius,
                half_length,
            } => {
                let mass = density * PI * radius * radius * 2.0 * half_length;
                let (across, along) = (radius * radius / 4.0, half_length * half_length / 3.0);
                BoneMass::centred(mass, mass * DVec3::new(across, across, along))
            }
            // A cylinder, and a ball cut in two: ⟨(l + ζ)²⟩ = l² + 2 l ⟨ζ⟩ + ⟨ζ²⟩, ⟨ζ⟩ = 3r/8, ⟨ζ²⟩ = r²/5.
            Self::Capsule {
                radius,
                half_length,
            } => {
                let cylinder = Self::Cylinder {
                    radius,
                    half_length,
                };
                let mut sum = cylinder.mass(density)?;
                let caps = ball(radius, density);
                for (row, other) in sum.second_moment.iter_mut().zip(caps.second_moment) {
                    row.iter_mut().zip(other).for_each(|(s, o)| *s += o);
                }
                sum.second_moment[2][2] +=
                    caps.mass() * half_length * (half_length + 0.75 * radius);
                sum
            }
            Self::Box {
                half_extents: [x, y, z],
            } => {
                let mass = density * 8.0 * x * y * z;
                BoneMass::centred(mass, mass / 3.0 * DVec3::new(x * x, y * y, z * z))
            }
        })
    }
}

pub(super) fn no_solid() -> Error {
    Error::invalid("shape", "a half-space is no body: it has no bounds")
}

/// ⟨x²⟩ = r²/5 in a ball, so that its moment of inertia is 2/5 m r².
fn ball(radius: f64, density: f64) -> BoneMass {
    let mass = density * 4.0 / 3.0 * PI * radius.powi(3);
    BoneMass::centred(mass, DVec3::splat(mass * radius * radius / 5.0))
}
