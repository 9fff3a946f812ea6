//! The reduced tissue at rest with its bones fixed: a linear system in the handles alone.
//!
//! ```text
//! K_hk = Σ_i w_i (∇U_h)ᵀ : C_i : ∇U_k    M_hk = ρ Σ_i w_i U_h U_k I
//! ```
//!
//! over the cubature points i, C_i = ∂P/∂F at F = I: the method's H_hk and M_φφ at φ = 0.
//!
//! Bones that are accelerated by 1 m/s² along d make the tissue sway by u_d = K⁻¹ f_d, f_d = M d. Were that a mode, it would
//! be u_d = d/ω² everywhere; a part of the tissue with the share s of each point has the frequency
//!
//! ```text
//! ω² = Σ_i m_i s_i u_d·d / Σ_i m_i s_i |u_d|²        along the softest d
//! ```
//!
//! which for all of it is Rayleigh's quotient uᵀ K u / uᵀ M u = Σ_k Γ_k²/ω_k² / Σ_k Γ_k²/ω_k⁴ with Γ_k = vₖᵀ f: of a plane layer
//! within 1 % the mode with the largest share of uniform sway. Where a part's sway is spread over many modes of the body,
//! it is their mean, and does not jump from one to the next as handles are added.

use crate::math::{DenseFactor, SparseFactor};
use crate::subspace::{lumped_mass, rest_stiffness};
use glam::{DMat3, DVec3};
use std::f64::consts::TAU;
use supple::Result;
use supple::internal::cpu::Basis;
use supple::internal::math::symmetric_eigen;
use supple::model::Avatar;

/// K and M of the handles at rest.
#[derive(Clone, Debug)]
pub struct RestSystem {
    /// K, N/m, its columns; x, y and z of a handle one after the other.
    pub stiffness: Vec<Vec<f64>>,
    /// M, kg, its columns; one a handle, the same for x, y and z.
    pub mass: Vec<Vec<f64>>,
    /// ρ Σ_i w_i U_h, kg: what an acceleration of the bones pulls a handle with.
    pub load: Vec<f64>,
}

impl RestSystem {
    /// Of `avatar`'s cubature points.
    pub fn of(avatar: &Avatar) -> Self {
        let n = avatar.handles.len();
        let mut stiffness = vec![vec![0.0; 3 * n]; 3 * n];
        let mut mass = vec![vec![0.0; n]; n];
        let mut load = vec![0.0; n];
        let points = &avatar.cubature;
        for (i, row) in points.basis.iter().enumerate() {
            let weight = points.measure[i];
            let tangent = avatar.tissue_at(i).tangent(DMat3::IDENTITY);
            for own in row {
                let force = own.stiffness(&tangent);
                let h = own.handle as usize;
                load[h] += avatar.density * weight * own.value;
                for other in row {
                    let k = other.handle as usize;
                    mass[h][k] += avatar.density * weight * own.value * other.value;
                    let block = other.contract(&force) * weight;
                    for (axis, column) in block.to_cols_array_2d().iter().enumerate() {
                        for (j, value) in column.iter().enumerate() {
                            stiffness[3 * k + axis][3 * h + j] += value;
                        }
                    }
                }
            }
        }
        Self {
            stiffness,
            mass,
            load,
        }
    }

    /// u of each handle, m, under 1 m/s² along x, y and z.
    ///
    /// # Errors
    /// [`supple::Error::Solve`] where K is singular.
    pub fn sway(&self) -> Result<[Vec<DVec3>; 3]> {
        let factor = DenseFactor::new(&self.stiffness, "reduced tissue at rest")?;
        Ok([DVec3::X, DVec3::Y, DVec3::Z].map(|d| {
            let f: Vec<f64> = self.load.iter().flat_map(|m| (d * *m).to_array()).collect();
            factor
                .solve(&f)
                .chunks_exact(3)
                .map(DVec3::from_slice)
                .collect()
        }))
    }

    /// fᵀ K⁻¹ f of the load f that an acceleration of 1 m/s² of the bones along `direction` is, J.
    ///
    /// # Errors
    /// [`supple::Error::Solve`] where K is singular.
    pub fn compliance(&self, direction: DVec3) -> Result<f64> {
        let factor = DenseFactor::new(&self.stiffness, "reduced tissue at rest")?;
        let f: Vec<f64> = (self.load.iter())
            .flat_map(|m| (direction * *m).to_array())
            .collect();
        Ok(factor.solve(&f).iter().zip(&f).map(|(u, f)| u * f).sum())
    }
}

/// ω/2π, Hz, of what sways by u under 1 m/s² along x, y and z: of (mass, u) of its points; 0 where nothing moves.
pub fn sway_frequency(points: impl IntoIterator<Item = (f64, [DVec3; 3])>) -> f64 {
    let (mut mean, mut square) = (DMat3::ZERO, DMat3::ZERO);
    for (mass, u) in points {
        let u = DMat3::from_cols(u[0], u[1], u[2]);
        mean += mass * 0.5 * (u + u.transpose());
        square += mass * (u.transpose() * u);
    }
    // The largest 1/ω² of B d = 1/ω² A d, A the mean and B the square, where A is positive.
    let (values, vectors) = symmetric_eigen(mean);
    let least = 1e-9 * values.max_element();
    let roots = values.map(|a| {
        if a > least.max(0.0) {
            a.sqrt().recip()
        } else {
            0.0
        }
    });
    let root = vectors * DMat3::from_diagonal(roots) * vectors.transpose();
    let (squares, _) = symmetric_eigen(root * square * root);
    match squares.max_element() {
        most if most > 0.0 => most.sqrt().recip() / TAU,
        _ => 0.0,
    }
}

/// [`RestSystem::compliance`] of every node of the layer along x, y and z, J.
///
/// # Errors
/// [`supple::Error::Solve`] where tissue hangs on no bone.
pub fn full_compliance(avatar: &Avatar) -> Result<[f64; 3]> {
    let factor = SparseFactor::new(&rest_stiffness(avatar), "tissue at rest")?;
    let mass = lumped_mass(avatar);
    let along = |axis: usize| {
        let mut f = vec![0.0; 3 * mass.len()];
        let own = f.iter_mut().skip(axis).step_by(3);
        own.zip(&mass).for_each(|(f, m)| *f = *m);
        factor.solve(&f).iter().zip(&f).map(|(u, f)| u * f).sum()
    };
    Ok([along(0), along(1), along(2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_softest_way_to_sway_is_the_first() {
        // Springs of 4, 1 and 9 Hz along turned axes.
        let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, -0.8, 1.1);
        let soft = DVec3::new(4.0, 1.0, 9.0).map(|f: f64| (TAU * f).powi(-2));
        let u = turn * DMat3::from_diagonal(soft) * turn.transpose();
        let point = |mass| (mass, [u.x_axis, u.y_axis, u.z_axis]);
        let found = sway_frequency([point(2.0), point(0.5)]);
        approx::assert_relative_eq!(found, 1.0, max_relative = 1e-12);
        assert_eq!(sway_frequency([]), 0.0);
        assert_eq!(sway_frequency([(1.0, [DVec3::ZERO; 3])]), 0.0);
    }
}
