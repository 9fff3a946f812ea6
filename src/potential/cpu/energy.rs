//! Energy differences of one point, from base to state, each summed from increments:
//!
//! ```text
//! inertia  m/(2h̃²) (|d + Δ − ŷ|² − |d − ŷ|²) = m/(2h̃²) Δ · (Δ + 2 (d − ŷ))
//! gravity  −m g · Δ
//! elastic  w (Ψ(F + ΔF) − Ψ(F))
//! damping  w β/(2h̃) ΔF : Cⁿ : (ΔF + 2 (F − F̃))
//! contact  ½ k a (δ + δ_base)(δ − δ_base)
//! friction μ λ (f₀(|u_T|) − f₀(|u_T,base|))
//! ```

use super::friction::smoothed_difference;
use crate::material::MaterialPoint;
use crate::math::{Mat9, contract, double_dot};
use crate::potential::Energies;
use glam::{DMat3, DVec3};

/// J; Δ = `change`, d − ŷ = `residual` at the base.
pub fn inertia(mass: f64, inertial_step: f64, change: DVec3, residual: DVec3) -> f64 {
    0.5 * mass / (inertial_step * inertial_step) * change.dot(change + 2.0 * residual)
}

/// J.
pub fn gravity(mass: f64, tissue_gravity: DVec3, change: DVec3) -> f64 {
    -mass * tissue_gravity.dot(change)
}

/// J; F = `base`, ΔF = `change`.
pub fn elastic(tissue: MaterialPoint<'_>, weight: f64, base: DMat3, change: DMat3) -> f64 {
    weight * tissue.energy_difference(base, change)
}

/// J; β/h̃ = `rate`, F − F̃ = `residual` at the base.
pub fn damping(weight: f64, rate: f64, tangent: &Mat9, change: DMat3, residual: DMat3) -> f64 {
    let mean = change + residual * 2.0;
    0.5 * weight * rate * double_dot(change, contract(tangent, mean))
}

/// J; `stiffness` is k a.
pub fn contact(stiffness: f64, base_depth: f64, depth: f64) -> f64 {
    0.5 * stiffness * (depth + base_depth) * (depth - base_depth)
}

/// J; `limit` is μ λ, ε = `smoothing`, |u_T| = `length`.
pub fn friction(limit: f64, smoothing: f64, base_length: f64, length: f64) -> f64 {
    limit * smoothed_difference(base_length, length, smoothing)
}

/// The sum, in order.
pub fn sum(points: &[Energies]) -> Energies {
    let mut total = Energies::default();
    for point in points {
        total.inertia += point.inertia;
        total.gravity += point.gravity;
        total.elastic += point.elastic;
        total.damping += point.damping;
        total.contact += point.contact;
        total.friction += point.friction;
    }
    total
}
