//! Stable neo-Hookean elasticity.

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
