//! A point's part of the energy's gradient, block by block:
//!
//! ```text
//! c_j: w_j f      ω_j: a_j × f      φ_h: N_hᵀ Bᵀ f + w P ∇U_h
//! ```
//!
//! f = m (d − ŷ)/h̃² − m g is the energy's gradient by the point's position, a_j its arms.

use super::Basis;
use super::point_hessian::PointView;
use glam::DVec3;

/// f, N.
pub fn point_force(
    mass: f64,
    inertial_step: f64,
    displacement: DVec3,
    predicted: DVec3,
    tissue_gravity: DVec3,
) -> DVec3 {
    mass * ((displacement - predicted) / (inertial_step * inertial_step) - tissue_gravity)
}

/// The point's part of the gradient by its local block `local`.
#[inline]
pub fn gradient<B: Basis>(point: &PointView<'_, B>, local: usize) -> DVec3 {
    let terms = point.terms;
    let frames = 2 * point.skinning.len();
    if local >= frames {
        let n = &point.basis[local - frames];
        n.pull_back(terms.pulled_force) + n.stress_force(terms.stress)
    } else if local.is_multiple_of(2) {
        point.skinning[local / 2].weight * terms.force
    } else {
        point.arms[local / 2].cross(terms.force)
    }
}
