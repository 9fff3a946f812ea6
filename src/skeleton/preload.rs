//! Springs that hold a pose are loaded by its weight beforehand.

use super::gravity::FrameGravity;
use super::log_derivative::{inverse_left_jacobian, log_curvature};
use super::term::{FrameHessian, FrameTerm, add_block};
use crate::math::rotation_log;
use crate::model::Frame;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// Which bones' springs carry the weight of the pose that they draw to without giving way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Preload {
    /// None: every spring gives way to what hangs on it, and what nothing draws hangs limp.
    Off,
    /// Those with targets of rotation and place, and of rotation on a parent that is held.
    #[default]
    Targets,
    /// All: those with targets, and from the root on those whose bending springs keep the rest pose. The root must be held:
    /// what carries its weight is no spring, and no pin reports it.
    Pose,
}

/// Where springs hold a bone, as far as they do.
#[derive(Clone, Copy, Debug, Default)]
pub struct Held {
    /// R̂.
    pub rotation: Option<DMat3>,
    /// ĉ: of its own target, or of a parent that is held.
    pub position: Option<DVec3>,
}

/// E = w·c + m·log(R R̂ᵀ) of a bone held at R̂, with its weight w and that weight's moment m about the joint:
/// −(∂E_gravity/∂θ)(θ̂) · (θ − θ̂), so that at θ̂ gravity pulls at no spring (method §8).
#[derive(Clone, Copy, Debug)]
pub struct PreloadedBone {
    bone: usize,
    /// R̂.
    rotation: DMat3,
    /// w, N.
    weight: DVec3,
    /// m, N·m.
    moment: DVec3,
}

impl PreloadedBone {
    /// What `bone` weighs where it is `held`; none where it is not, or in part.
    pub fn new(bone: usize, held: &Held, gravity: &FrameGravity) -> Option<Self> {
        let (rotation, _) = held.rotation.zip(held.position)?;
        let (weight, moment) = gravity.wrench(bone, &rotation);
        Some(Self {
            bone,
            rotation,
            weight,
            moment,
        })
    }

    /// Which bone.
    pub fn bone(&self) -> usize {
        self.bone
    }

    /// The force and the torque about the joint with which it is carried, N and N·m.
    pub fn load(&self, frames: &[Frame]) -> (DVec3, DVec3) {
        let slope = inverse_left_jacobian(self.turn(frames)).transpose();
        (-self.weight, -(slope * self.moment))
    }

    /// log(R R̂ᵀ).
    fn turn(&self, frames: &[Frame]) -> DVec3 {
        rotation_log(frames[self.bone].rotation * self.rotation.transpose())
    }
}

impl FrameTerm for PreloadedBone {
    fn difference(&self, base: &[Frame], frames: &[Frame]) -> f64 {
        let moved = frames[self.bone].position - base[self.bone].position;
        self.weight.dot(moved) + self.moment.dot(self.turn(frames) - self.turn(base))
    }

    fn add_derivatives(
        &self,
        frames: &[Frame],
        gradient: &mut [f64],
        _hessian: &mut FrameHessian<'_>,
    ) {
        add_block(gradient, 2 * self.bone, self.weight);
        let slope = inverse_left_jacobian(self.turn(frames)).transpose();
        add_block(gradient, 2 * self.bone + 1, slope * self.moment);
    }

    fn add_geometric(&self, frames: &[Frame], hessian: &mut FrameHessian<'_>) {
        let rotation = 2 * self.bone + 1;
        hessian.add(
            rotation,
            rotation,
            log_curvature(self.turn(frames), self.moment),
        );
    }
}
