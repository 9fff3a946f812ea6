//! Elasticity and lagged damping at a cubature point:
//!
//! ```text
//! F = I + Σ_h φ_h ∇U_hᵀ    P = P(F) + (β/h̃) Cⁿ : (F − F̃)    C = C⁺(F) + (β/h̃) Cⁿ
//! ```
//!
//! with C⁺ the tangent projected to positive semi-definite, Cⁿ = C⁺(Fⁿ), and F̃ = a₀ Fⁿ − a₁ Fⁿ⁻¹.

use super::Basis;
use crate::material::MaterialPoint;
use crate::math::{Mat9, contract};
use glam::{DMat3, DVec3};

/// F − I = Σ_h φ_h ∇U_hᵀ.
pub fn displacement_gradient<B: Basis>(basis: &[B], handles: &[DVec3]) -> DMat3 {
    basis
        .iter()
        .map(|n| n.deformation(handles[n.handle()]))
        .sum()
}

/// Stiffness-proportional damping, lagged: its coefficients do not change within a step.
#[derive(Clone, Copy, Debug)]
pub struct Damping<'a> {
    /// β/h̃.
    pub rate: f64,
    /// Cⁿ, Pa.
    pub tangent: &'a Mat9,
    /// F − F̃.
    pub change: DMat3,
}

/// P, Pa, with the damping's part.
pub fn stress(
    tissue: MaterialPoint<'_>,
    deformation_gradient: DMat3,
    damping: Option<Damping<'_>>,
) -> DMat3 {
    let elastic = tissue.pk1_stress(deformation_gradient);
    match damping {
        Some(d) => elastic + contract(d.tangent, d.change) * d.rate,
        None => elastic,
    }
}

/// w C, J: the projected tangent with the damping's part, times the cubature weight.
pub fn tangent(
    tissue: MaterialPoint<'_>,
    deformation_gradient: DMat3,
    damping: Option<Damping<'_>>,
    weight: f64,
) -> Mat9 {
    let mut c = tissue.projected_tangent(deformation_gradient);
    for (row, entries) in c.iter_mut().enumerate() {
        for (column, entry) in entries.iter_mut().enumerate() {
            let damping = damping.map_or(0.0, |d| d.rate * d.tangent[row][column]);
            *entry = weight * (*entry + damping);
        }
    }
    c
}
