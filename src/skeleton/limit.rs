//! Springs that keep joints within their ranges.

use super::bending::add_relative_curvature;
use super::log_derivative::{inverse_left_jacobian, log_curvature};
use super::swing_twist::SwingTwist;
use super::term::{FrameHessian, FrameTerm, Residual, relative_rotation};
use crate::math::rotation_log;
use crate::model::{Frame, JointRange};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// The range of a bone's rotation relative to its parent, and how stiffly it is kept. A root has no
/// parent and no limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct JointLimit {
    /// Which bone.
    pub bone: usize,
    /// Where it may turn.
    pub range: JointRange,
    /// k, N·m/rad.
    pub stiffness: f64,
    /// d/k, s: what begins a step out of its range is damped by d in it.
    #[serde(skip)]
    pub damping_time: f64,
}

/// E = ½ k |e|² with Q = R_pᵀ R_j and what of it is out of its range:
/// - of a box with axes A, e = s − clamp(s), s = Aᵀ log Q;
/// - of a cone, e = ((β − β_max)₊, τ − clamp(τ)) with β, τ the swing and the twist of Q.
///
/// Where a half-turn takes log Q or τ to the other side E jumps; ranges that end well short of it keep
/// bones away from there.
#[derive(Clone, Copy, Debug)]
pub struct LimitSpring {
    /// j.
    pub child: usize,
    /// p.
    pub parent: usize,
    /// The range and k.
    pub limit: JointLimit,
}

/// What Q ← exp(\[ε\]) Q does to E at ε = 0.
struct Local {
    /// ∂E/∂ε.
    torque: DVec3,
    /// k Σ ∂e ∂eᵀ.
    gauss_newton: DMat3,
    /// k Σ e ∂²e.
    curvature: DMat3,
}

/// x − clamp(x).
fn beyond(x: f64, least: f64, most: f64) -> f64 {
    x - x.clamp(least, most)
}

fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

impl LimitSpring {
    /// d of the damper that stops it in a step from `frames`, N·m·s; 0 within its range.
    pub fn damping(&self, frames: &[Frame]) -> f64 {
        match self.excess(self.relative(frames)) == DVec3::ZERO {
            true => 0.0,
            false => self.limit.damping_time * self.limit.stiffness,
        }
    }

    fn relative(&self, frames: &[Frame]) -> DMat3 {
        relative_rotation(frames, self.parent, self.child)
    }

    /// e: three parts of a box, swing and twist of a cone.
    fn excess(&self, relative: DMat3) -> DVec3 {
        match self.limit.range {
            JointRange::Axes { axes, least, most } => {
                let s = axes.transpose() * rotation_log(relative);
                s - s.clamp(least, most)
            }
            JointRange::Cone { axis, swing, twist } => {
                let now = SwingTwist::new(relative, axis);
                let excess = beyond(now.twist, twist[0], twist[1]);
                DVec3::new((now.swing - swing).max(0.0), excess, 0.0)
            }
        }
    }

    fn local(&self, relative: DMat3) -> Local {
        let (k, e) = (self.limit.stiffness, self.excess(relative));
        match self.limit.range {
            JointRange::Axes { axes, .. } => {
                let r = rotation_log(relative);
                let slope = inverse_left_jacobian(r);
                let force = k * (axes * e);
                // Only axes that are out of range resist.
                let active = DVec3::select(e.cmpne(DVec3::ZERO), DVec3::splat(k), DVec3::ZERO);
                let stiffness = axes * DMat3::from_diagonal(active) * axes.transpose();
                Local {
                    torque: slope.transpose() * force,
                    gauss_newton: slope.transpose() * stiffness * slope,
                    curvature: log_curvature(r, force),
                }
            }
            JointRange::Cone { axis, .. } => {
                let now = SwingTwist::new(relative, axis);
                let parts = [(e.x, now.swing_slope()), (e.y, now.twist_slope())];
                let curvatures = [now.swing_curvature(), now.twist_curvature()];
                let mut local = Local {
                    torque: DVec3::ZERO,
                    gauss_newton: DMat3::ZERO,
                    curvature: DMat3::ZERO,
                };
                for ((e, slope), curvature) in parts.into_iter().zip(curvatures) {
                    if e != 0.0 {
                        local.torque += k * e * slope;
                        local.gauss_newton += outer(slope, slope) * k;
                        local.curvature += curvature * (k * e);
                    }
                }
                local
            }
        }
    }
}

impl FrameTerm for LimitSpring {
    fn difference(&self, base: &[Frame], frames: &[Frame]) -> f64 {
        let e = self.excess(self.relative(frames));
        let e0 = self.excess(self.relative(base));
        0.5 * self.limit.stiffness * (e - e0).dot(e + e0)
    }

    fn add_derivatives(
        &self,
        frames: &[Frame],
        gradient: &mut [f64],
        hessian: &mut FrameHessian<'_>,
    ) {
        let relative = self.relative(frames);
        if self.excess(relative) == DVec3::ZERO {
            return;
        }
        let local = self.local(relative);
        // ε = R_pᵀ (δω_j − δω_p).
        let turn = frames[self.parent].rotation.transpose();
        let (child, parent) = (2 * self.child + 1, 2 * self.parent + 1);
        let residual = Residual {
            jacobian: [(child, turn), (parent, -turn)],
        };
        residual.add_gradient(local.torque, gradient);
        let stiffness = turn.transpose() * local.gauss_newton * turn;
        hessian.add(child, child, stiffness);
        hessian.add(parent, parent, stiffness);
        hessian.add(parent, child, -stiffness);
    }

    fn add_geometric(&self, frames: &[Frame], hessian: &mut FrameHessian<'_>) {
        let local = self.local(self.relative(frames));
        let blocks = [2 * self.child + 1, 2 * self.parent + 1];
        let parent = &frames[self.parent].rotation;
        add_relative_curvature(blocks, parent, local.curvature, local.torque, hessian);
    }
}
