//! What tissue is made of: one file a material with Ψ, P = ∂Ψ/∂F and ∂P/∂F in f64, the names of its kernels, and
//! the parameters that they read.
//!
//! [`Material`] answers in the material's own axes; [`MaterialPoint`] is a material at a point of a body, with the stiffness and
//! the axes that it has there ([`LocalTissue`]).

mod damping;
mod fung_neo_hookean;
mod local;
mod neo_hookean;
mod orthotropic;
mod stable_neo_hookean;

pub use damping::{DEFAULT_BOUNCE, damping_ratio, damping_time};
pub use fung_neo_hookean::FungNeoHookean;
pub use local::{LocalTissue, MaterialPoint};
pub use orthotropic::Orthotropic;
pub use stable_neo_hookean::StableNeoHookean;

use crate::Result;
#[cfg(feature = "gpu")]
use crate::gpu::SharedValue;
use crate::math::Mat9;
use glam::DMat3;
use serde::{Deserialize, Serialize};

/// What a hyperelastic material answers at one deformation gradient F.
pub trait Hyperelastic {
    /// Checks the parameters; an error names the one at fault.
    fn validate(&self) -> Result<()>;

    /// Whether Ψ(F G) = Ψ(F) for all rotations G: then no axes are looked at.
    fn is_isotropic(&self) -> bool;

    /// Ψ(F), Pa; 0 at rest.
    fn energy_density(&self, deformation_gradient: DMat3) -> f64;

    /// Ψ(F + ΔF) − Ψ(F), Pa, summed from terms that each vanish with ΔF.
    fn energy_difference(&self, deformation_gradient: DMat3, change: DMat3) -> f64;

    /// P = ∂Ψ/∂F, Pa.
    fn pk1_stress(&self, deformation_gradient: DMat3) -> DMat3;

    /// C = ∂P/∂F, Pa.
    fn tangent(&self, deformation_gradient: DMat3) -> Mat9;

    /// [`Hyperelastic::tangent`] with its negative eigenvalues set to 0, Pa.
    fn projected_tangent(&self, deformation_gradient: DMat3) -> Mat9;

    /// What the kernel reads.
    #[cfg(feature = "gpu")]
    fn parameters(&self) -> SharedValue;

    /// Files of the kernel under `kernels/`, in order.
    fn kernels(&self) -> &'static [&'static str];
}

/// A hyperelastic energy density of the deformation gradient. A new material is one file, its
/// kernel, and its lines in this enum.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Material {
    /// Smith et al. 2018.
    StableNeoHookean(StableNeoHookean),
    /// That, with fibres and Fung's saturation.
    Orthotropic(Orthotropic),
    /// The first, stiffening by Fung's exponential of an invariant.
    FungNeoHookean(FungNeoHookean),
}

impl std::fmt::Display for Material {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::StableNeoHookean(m) => write!(
                f,
                "stable neo-Hookean, E = {} Pa, ν = {}",
                m.youngs_modulus, m.poissons_ratio
            ),
            Self::Orthotropic(m) => {
                let [normal, along, around] = m.fibre_moduli;
                write!(
                    f,
                    "orthotropic, E = {} Pa, ν = {}, fibres {normal} Pa across, {along} along and {around} around, \
                     saturation {} Pa up to Q = {}",
                    m.youngs_modulus, m.poissons_ratio, m.saturation, m.saturation_limit
                )
            }
            Self::FungNeoHookean(m) => write!(
                f,
                "Fung's neo-Hookean, E = {} Pa, ν = {}, stiffening {} up to an exponent of {}",
                m.youngs_modulus, m.poissons_ratio, m.stiffening, m.stiffening_limit
            ),
        }
    }
}

impl Material {
    /// One of each material with tissue-like parameters: what loops over all materials loops over.
    pub fn examples() -> Vec<Self> {
        vec![
            Self::StableNeoHookean(StableNeoHookean {
                youngs_modulus: 3e4,
                poissons_ratio: 0.45,
            }),
            Self::FungNeoHookean(FungNeoHookean::from_shear_modulus(750.0, 0.4)),
            Self::Orthotropic(Orthotropic::default()),
        ]
    }

    fn model(&self) -> &dyn Hyperelastic {
        match self {
            Self::StableNeoHookean(model) => model,
            Self::Orthotropic(model) => model,
            Self::FungNeoHookean(model) => model,
        }
    }

    /// E, Pa, and ν of small strains, of its isotropic part.
    fn elastic_constants(&self) -> (f64, f64) {
        match self {
            Self::StableNeoHookean(m) => (m.youngs_modulus, m.poissons_ratio),
            Self::Orthotropic(m) => (m.youngs_modulus, m.poissons_ratio),
            Self::FungNeoHookean(m) => (m.youngs_modulus, m.poissons_ratio),
        }
    }

    /// E, Pa: Young's modulus of small strains, of its isotropic part.
    pub fn youngs_modulus(&self) -> f64 {
        self.elastic_constants().0
    }

    /// G = E/(2 (1 + ν)), Pa, of small strains, of its isotropic part.
    pub fn shear_modulus(&self) -> f64 {
        let (e, nu) = self.elastic_constants();
        e / (2.0 * (1.0 + nu))
    }

    /// The material where the tissue is `local`.
    pub fn at(&self, local: LocalTissue) -> MaterialPoint<'_> {
        MaterialPoint {
            material: self,
            local,
        }
    }

    /// Whether Ψ(F G) = Ψ(F) for all rotations G: then no axes are looked at.
    pub fn is_isotropic(&self) -> bool {
        self.model().is_isotropic()
    }

    /// Checks the parameters; an error names the one at fault.
    pub fn validate(&self) -> Result<()> {
        self.model().validate()
    }

    /// Ψ(F), Pa; 0 at rest.
    pub fn energy_density(&self, deformation_gradient: DMat3) -> f64 {
        self.model().energy_density(deformation_gradient)
    }

    /// Ψ(F + ΔF) − Ψ(F), Pa, summed from terms that each vanish with ΔF.
    pub fn energy_difference(&self, deformation_gradient: DMat3, change: DMat3) -> f64 {
        self.model().energy_difference(deformation_gradient, change)
    }

    /// P = ∂Ψ/∂F, Pa.
    pub fn pk1_stress(&self, deformation_gradient: DMat3) -> DMat3 {
        self.model().pk1_stress(deformation_gradient)
    }

    /// C = ∂P/∂F, Pa.
    pub fn tangent(&self, deformation_gradient: DMat3) -> Mat9 {
        self.model().tangent(deformation_gradient)
    }

    /// [`Material::tangent`] with its negative eigenvalues set to 0, Pa.
    pub fn projected_tangent(&self, deformation_gradient: DMat3) -> Mat9 {
        self.model().projected_tangent(deformation_gradient)
    }

    /// What the kernel reads.
    #[cfg(feature = "gpu")]
    pub fn parameters(&self) -> SharedValue {
        self.model().parameters()
    }

    /// Files of the kernel under `kernels/`, in order.
    pub fn kernels(&self) -> &'static [&'static str] {
        self.model().kernels()
    }
}

#[cfg(test)]
mod tests;
