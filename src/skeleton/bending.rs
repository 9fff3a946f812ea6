//! Springs that keep the rotation of a bone relative to its parent.

use super::log_derivative::{inverse_left_jacobian, log_curvature};
use super::term::{FrameHessian, FrameTerm, Residual, relative_rotation};
use crate::math::{rotation_exp, rotation_log, skew};
use crate::model::{Frame, InertialTarget};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// How stiffly a bone keeps its rotation relative to its parent. A root has no parent: its entry
/// does nothing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bending {
    /// R₀: the relative rotation R_pᵀR_j at rest.
    pub rest_rotation: DMat3,
    /// k, N·m/rad.
    pub stiffness: f64,
    /// d, N·m·s: against any rotation relative to the parent.
    #[serde(skip)]
    pub damping: f64,
}

/// E = ½ k |r|², r = log(R_pᵀ R_j R₀⁻¹).
///
/// A damper is one with k = d/h̃ from the rotation Q̃ that the step takes velocities from: |log(Q Q̃ᵀ)| is what Q = R_pᵀ R_j turns
/// in h̃, however far it is from rest.
///
/// With R ← exp(\[δω\]) R: δr = J_l⁻¹(r) R_pᵀ (δω_j − δω_p).
#[derive(Clone, Copy, Debug)]
pub struct BendingSpring {
    /// j.
    pub child: usize,
    /// p.
    pub parent: usize,
    /// R₀ and k.
    pub bending: Bending,
}

impl BendingSpring {
    /// The damper of `damping` d of `child` on `parent` in a step that starts from `current`: with Qⁿ and Qⁿ⁻¹ there and a
    /// step before, Q̃ = exp(a₁ log(Qⁿ Qⁿ⁻¹ᵀ)) Qⁿ.
    pub fn damper(
        child: usize,
        parent: usize,
        damping: f64,
        current: &[Frame],
        inertia: &InertialTarget<'_>,
    ) -> Self {
        let relative = |frames: &[Frame]| relative_rotation(frames, parent, child);
        let mut from = relative(current);
        if let ([before, ..], true) = (inertia.past, inertia.drift != 0.0) {
            let turned = rotation_log(from * relative(&before.frames).transpose());
            from = rotation_exp(turned * inertia.drift) * from;
        }
        Self {
            child,
            parent,
            bending: Bending {
                rest_rotation: from,
                stiffness: damping / inertia.step,
                damping: 0.0,
            },
        }
    }

    /// r, rad.
    fn residual(&self, frames: &[Frame]) -> DVec3 {
        let relative = relative_rotation(frames, self.parent, self.child);
        rotation_log(relative * self.bending.rest_rotation.transpose())
    }
}

impl FrameTerm for BendingSpring {
    fn difference(&self, base: &[Frame], frames: &[Frame]) -> f64 {
        let (r, r0) = (self.residual(frames), self.residual(base));
        0.5 * self.bending.stiffness * (r - r0).dot(r + r0)
    }

    fn add_derivatives(
        &self,
        frames: &[Frame],
        gradient: &mut [f64],
        hessian: &mut FrameHessian<'_>,
    ) {
        let r = self.residual(frames);
        let slope = inverse_left_jacobian(r) * frames[self.parent].rotation.transpose();
        let residual = Residual {
            jacobian: [(2 * self.child + 1, slope), (2 * self.parent + 1, -slope)],
        };
        residual.add_gradient(self.bending.stiffness * r, gradient);
        residual.add_hessian(self.bending.stiffness, hessian);
    }

    fn add_geometric(&self, frames: &[Frame], hessian: &mut FrameHessian<'_>) {
        let r = self.residual(frames);
        let force = self.bending.stiffness * r;
        add_relative_curvature(
            [2 * self.child + 1, 2 * self.parent + 1],
            &frames[self.parent].rotation,
            log_curvature(r, force),
            inverse_left_jacobian(r).transpose() * force,
            hessian,
        );
    }
}

/// Adds the curvature of a function of Q = R_pᵀ R_j to the blocks (ω_j, ω_p) of `blocks`; `curvature`
/// and `torque` are its second and first derivatives by ε in Q ← exp(\[ε\]) Q.
///
/// exp(−ta) exp(tb) = exp(t(b − a) − ½t² a × b + …) with a, b = R_pᵀω_p, R_pᵀω_j: besides the
/// curvature in b − a there is −torque · (a × b), half of it in each mixed block.
pub(super) fn add_relative_curvature(
    blocks: [usize; 2],
    parent: &DMat3,
    curvature: DMat3,
    torque: DVec3,
    hessian: &mut FrameHessian<'_>,
) {
    let turned = |m: DMat3| *parent * m * parent.transpose();
    let (curvature, order) = (turned(curvature), turned(skew(torque)) * 0.5);
    let [child, parent] = blocks;
    hessian.add(child, child, curvature);
    hessian.add(parent, parent, curvature);
    hessian.add(parent, child, order - curvature);
}
