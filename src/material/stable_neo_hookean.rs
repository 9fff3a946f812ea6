//! Stable neo-Hookean elasticity: the ground substance alone, see the module `neo_hookean` for the formulas.

use super::Hyperelastic;
use super::neo_hookean::{self, NeoHookean};
use crate::Result;
#[cfg(feature = "gpu")]
use crate::gpu::{SharedValue, host_shareable};
use crate::math::Mat9;
use glam::DMat3;
use serde::{Deserialize, Serialize};

/// Ψ = μ/2 (I_C − 3) − μ (J − 1) + (λ + μ)/2 (J − 1)²  (Smith et al. 2018, with λ reparametrised so
/// that ν is Poisson's ratio at rest).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StableNeoHookean {
    /// Young's modulus E, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio ν, in (−1, 0.5).
    pub poissons_ratio: f64,
}

#[cfg(feature = "gpu")]
host_shareable! {
    /// What the kernel reads (kernels/material/stable_neo_hookean.wgsl).
    pub struct StableNeoHookeanParameters {
        /// μ, Pa.
        pub mu: f32,
        /// λ, Pa.
        pub lambda: f32,
    }
}

impl StableNeoHookean {
    /// Lamé parameters (μ, λ), Pa.
    pub fn lame(&self) -> (f64, f64) {
        let NeoHookean { mu, lambda } = self.law();
        (mu, lambda)
    }

    pub(super) fn law(&self) -> NeoHookean {
        NeoHookean::new(self.youngs_modulus, self.poissons_ratio)
    }
}

impl Hyperelastic for StableNeoHookean {
    fn validate(&self) -> Result<()> {
        neo_hookean::validate(self.youngs_modulus, self.poissons_ratio)
    }

    fn is_isotropic(&self) -> bool {
        true
    }

    fn energy_density(&self, f: DMat3) -> f64 {
        self.law().energy_density(f)
    }

    fn energy_difference(&self, f: DMat3, d: DMat3) -> f64 {
        self.law().energy_difference(f, d)
    }

    fn pk1_stress(&self, f: DMat3) -> DMat3 {
        self.law().pk1_stress(f)
    }

    fn tangent(&self, f: DMat3) -> Mat9 {
        self.law().tangent(f, 0.0)
    }

    fn projected_tangent(&self, f: DMat3) -> Mat9 {
        self.law().projected_tangent(f, 0.0)
    }

    #[cfg(feature = "gpu")]
    fn parameters(&self) -> SharedValue {
        let (mu, lambda) = self.lame();
        let parameters = StableNeoHookeanParameters {
            mu: mu as f32,
            lambda: lambda as f32,
        };
        parameters.into()
    }

    fn kernels(&self) -> &'static [&'static str] {
        &[
            "shared/neo_hookean.wgsl",
            "shared/neo_hookean_modes.wgsl",
            "material/stable_neo_hookean.wgsl",
        ]
    }
}
