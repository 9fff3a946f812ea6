//! The reduced tissue at rest with its bones fixed: a linear system in the handles alone.
//!
//! ```text
//! K_hk = Σ_i w_i (∇U_h)ᵀ : C_i : ∇U_k    M_hk = ρ Σ_i w_i U_h U_k I
//! ```
//!
//! over the cubature points i, C_i = ∂P/∂F at F = I: the method's H_hk and M_φφ at φ = 0.

use crate::math::{DenseFactor, SparseFactor};
use crate::subspace::{lumped_mass, rest_stiffness};
use glam::{DMat3, DVec3};
use supple::Result;
use supple::internal::cpu::Basis;
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
