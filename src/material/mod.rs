//! What tissue is made of: one file a material with Ψ, P = ∂Ψ/∂F and ∂P/∂F in f64, and the name of
//! its kernel.

mod stable_neo_hookean;

pub use stable_neo_hookean::StableNeoHookean;

use crate::Result;
use crate::math::Mat9;
use glam::DMat3;
use serde::{Deserialize, Serialize};

/// A hyperelastic energy density of the deformation gradient. A new material is one file, its
/// kernel, and a line in [`Material`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "model", rename_all = "snake_case")]
pub enum Material {
    /// Smith et al. 2018.
    StableNeoHookean(StableNeoHookean),
}

impl Material {
    /// Checks the parameters.
    pub fn validate(&self) -> Result<()> {
        todo!()
    }

    /// Ψ(F), Pa.
    pub fn energy_density(&self, _deformation_gradient: DMat3) -> f64 {
        todo!()
    }

    /// P = ∂Ψ/∂F, Pa.
    pub fn pk1_stress(&self, _deformation_gradient: DMat3) -> DMat3 {
        todo!()
    }

    /// C = ∂P/∂F, Pa.
    pub fn tangent(&self, _deformation_gradient: DMat3) -> Mat9 {
        todo!()
    }

    /// [`Material::tangent`] with its negative eigenvalues set to 0, Pa.
    pub fn projected_tangent(&self, _deformation_gradient: DMat3) -> Mat9 {
        todo!()
    }
}
