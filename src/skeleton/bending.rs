//! Springs and dampers of the rotation of a bone relative to its parent.

use super::damper::Damper;
use super::log_derivative::{inverse_left_jacobian, log_curvature};
use super::term::{FrameHessian, FrameTerm, Residual};
use crate::math::{rotation_log, skew};
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
    /// d, N·m·s: against any motion relative to the parent.
    #[serde(skip)]
    pub damping: f64,
}

/// E = ½ k |r|² + ½ d/h̃ |r − r̃|², r = log(R_pᵀ R_j R₀⁻¹).
///
/// With R ← exp(\[δω\]) R: δr = J_l⁻¹(r) R_pᵀ (δω_j − δω_p).
#[derive(Clone, Copy, Debug)]
pub struct BendingSpring {
    /// j.
    pub child: usize,
    /// p.
    pub parent: usize,
    /// R₀, k and d.
    pub bending: Bending,
    /// d/h̃ and r̃.
    damper: Damper,
}

impl BendingSpring {
    /// The term of `child` on `parent` in a step that starts from `current`.
    pub fn new(
        [child, parent]: [usize; 2],
        bending: Bending,
        current: &[Frame],
        inertia: &InertialTarget<'_>,
    ) -> Self {
        let mut spring = Self {
            child,
            parent,
            bending,
            damper: Damper::NONE,
        };
        spring.damper = Damper::new(bending.damping, current, inertia, |f| spring.residual(f));
        spring
    }

    /// r, rad.
    fn residual(&self, frames: &[Frame]) -> DVec3 {
        let (parent, child) = (&frames[self.parent], &frames[self.child]);
        rotation_log(
            parent.rotation.transpose() * child.rotation * self.bending.rest_rotation.transpose(),
        )
    }
}

impl FrameTerm for BendingSpring {
    fn difference(&self, base: &[Frame], frames: &[Frame]) -> f64 {
        let (r, r0) = (self.residual(frames), self.residual(base));
        self.damper.difference(self.bending.stiffness, r0, r)
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
        let k = self.bending.stiffness;
        residual.add_gradient(self.damper.slope(k, r), gradient);
        residual.add_hessian(self.damper.stiffness(k), hessian);
    }

    fn add_geometric(&self, frames: &[Frame], hessian: &mut FrameHessian<'_>) {
        let r = self.residual(frames);
        let force = self.damper.slope(self.bending.stiffness, r);
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
