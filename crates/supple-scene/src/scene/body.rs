//! Rigid bodies of a scene.

use super::SceneShape;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use supple::Result;
use supple::internal::math::rotation_exp;
use supple::model::{Frame, RigidBody};

/// A rigid body that moves freely. Pins and targets may name it as they name a bone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneBody {
    /// Its name: unlike every bone's.
    pub name: String,
    /// m; anything but a half-space.
    pub shape: SceneShape,
    /// kg/m³.
    #[serde(default = "density")]
    pub density: f64,
    /// In place of what the density makes, kg.
    pub mass: Option<f64>,
    /// Penalty stiffness of what touches it, Pa/m; as a rule that of the tissue that it touches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness: Option<f64>,
    /// Coefficient of friction μ of what touches it, 0 to 10.
    #[serde(default)]
    pub friction: f64,
    /// Where it is at first, m.
    #[serde(default)]
    pub position: DVec3,
    /// How it stands at first: a rotation vector, degrees.
    #[serde(default)]
    pub rotation_degrees: DVec3,
    /// How it moves at first, m/s.
    #[serde(default)]
    pub velocity: DVec3,
    /// How it turns at first, degrees a second.
    #[serde(default)]
    pub spin_degrees: DVec3,
}

fn density() -> f64 {
    1000.0
}

impl SceneBody {
    /// Where it is at first.
    pub fn initial_frame(&self) -> Frame {
        Frame {
            rotation: rotation_exp(self.rotation_degrees * PI / 180.0),
            position: self.position,
        }
    }

    /// How it turns at first, rad/s.
    pub fn spin(&self) -> DVec3 {
        self.spin_degrees * PI / 180.0
    }

    /// The body in its place.
    ///
    /// # Errors
    /// As [`RigidBody::new`].
    pub fn rigid_body(&self) -> Result<RigidBody> {
        let body = RigidBody {
            stiffness: self.stiffness,
            friction: self.friction,
            ..RigidBody::new(&self.name, (*self.shape).clone(), self.density)?
                .at(self.initial_frame())
        };
        Ok(match self.mass {
            Some(mass) => body.of_mass(mass),
            None => body,
        })
    }
}
