//! Neo-Hookean tissue that stiffens as Fung's exponential has it.
//!
//! In terms of Q, which is 0 for rotations and 2 ε : ε for small strains (the module `neo_hookean`):
//!
//! ```text
//! Ψ = μ/(2b) g(b Q) + λ/2 (J − 1)²        Q = I_C − 4J + J²
//! g(y) = e^y − 1                                  y ≤ y_max
//! g(y) = e^y_max (1 + z + ½ z²) − 1               z = y − y_max > 0
//! P = μ g′ A + λ (J − 1) cof F                    A = ½ ∂Q/∂F = F − cof F + (J − 1) cof F
//! C = C₀(μ g′, λ) + 2 μ b g″ A ⊗ A                g″ = e^min(y, y_max),   g′ = g″ (1 + max(z, 0))
//! ```
//!
//! so that stress and tangent are those of the stable neo-Hookean law with μ g′ in place of μ, and one term more, which is a
//! scaling in the frame of the singular values: the eigenvalues stay closed-form. g′(0) = 1 and A = 0 at rest: E and ν are the
//! moduli of small strains whatever b is, and with b → 0 it is the stable neo-Hookean law. Past y_max the exponential goes on
//! as its Taylor polynomial of degree two: energy, stress and tangent stay continuous, and nothing overflows.
//!
//! The exponential of an invariant is Demiray's ("A note on the elasticity of soft biological tissues", 1972: I_C − 3 of
//! incompressible tissue) after Fung ("Elasticity of soft tissues in simple elongation", 1967); Q takes its place where
//! the volume changes, since I_C − 3 alone has a stress at rest. In simple shear γ it is τ = μ γ e^(b γ²).

use super::Hyperelastic;
use super::neo_hookean::{self, Differences, NeoHookean};
#[cfg(feature = "gpu")]
use crate::gpu::{SharedValue, host_shareable};
use crate::math::Mat9;
use crate::{Error, Result};
use glam::DMat3;
use serde::{Deserialize, Serialize};

/// Past this e^y_max kernels would overflow.
const MOST_STIFFENING_LIMIT: f64 = 30.0;

/// Ψ = μ/(2b) (e^(b Q) − 1) + λ/2 (J − 1)², Q = I_C − 4J + J²: soft at rest, the stiffer the farther it is strained.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FungNeoHookean {
    /// Young's modulus E of small strains, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio ν of small strains, in (−1, 0.5).
    pub poissons_ratio: f64,
    /// b, 0 or more: in shear by 1/√b the tissue is e times as stiff. 0: it does not stiffen.
    #[serde(default = "default_stiffening")]
    pub stiffening: f64,
    /// y_max, above 0 and up to 30: the b Q past which the exponential goes on as a polynomial of degree two.
    #[serde(default = "default_stiffening_limit")]
    pub stiffening_limit: f64,
}

fn default_stiffening() -> f64 {
    FungNeoHookean::STIFFENING
}

fn default_stiffening_limit() -> f64 {
    FungNeoHookean::STIFFENING_LIMIT
}

#[cfg(feature = "gpu")]
host_shareable! {
    /// What the kernel reads (kernels/material/fung_neo_hookean.wgsl).
    pub struct FungNeoHookeanParameters {
        /// μ, Pa.
        pub mu: f32,
        /// λ, Pa.
        pub lambda: f32,
        /// b.
        pub stiffening: f32,
        /// y_max.
        pub stiffening_limit: f32,
    }
}

impl FungNeoHookean {
    /// b of a person's soft tissue. Fat pressed to 0.5 to 0.7 of its height stiffens in shear by λ^−2.4 (MR elastography, J Mech Behav
    /// Biomed Mater 2023), for which b is 1 to 2; and with 1 a run moves a large breast by 0.11 m, where neo-Hookean tissue would
    /// move by 0.3 and people's by 0.15 ± 0.04 (Scurr, White and Hedger 2011): a test has both.
    pub const STIFFENING: f64 = 1.0;
    /// e⁴ is 55; with b = 1 a shear of 2 comes to it.
    pub const STIFFENING_LIMIT: f64 = 4.0;

    /// Tissue of a shear modulus G of small strains, Pa, that stiffens as people's does.
    pub fn from_shear_modulus(shear_modulus: f64, poissons_ratio: f64) -> Self {
        Self {
            youngs_modulus: 2.0 * (1.0 + poissons_ratio) * shear_modulus,
            poissons_ratio,
            stiffening: Self::STIFFENING,
            stiffening_limit: Self::STIFFENING_LIMIT,
        }
    }

    /// Lamé parameters (μ, λ) of small strains, Pa.
    pub fn lame(&self) -> (f64, f64) {
        let NeoHookean { mu, lambda } = self.ground();
        (mu, lambda)
    }

    fn ground(&self) -> NeoHookean {
        NeoHookean::new(self.youngs_modulus, self.poissons_ratio)
    }

    /// y = b Q of F = I + H.
    fn exponent(&self, h: DMat3) -> f64 {
        self.stiffening * neo_hookean::strain(h)
    }

    /// The law with μ g′ for μ, and a = 2 μ b g″, at F.
    fn stiffened(&self, f: DMat3) -> (NeoHookean, f64) {
        let y = self.exponent(f - DMat3::IDENTITY);
        let NeoHookean { mu, lambda } = self.ground();
        let second = y.min(self.stiffening_limit).exp();
        let first = second * (1.0 + (y - self.stiffening_limit).max(0.0));
        let law = NeoHookean {
            mu: mu * first,
            lambda,
        };
        (law, 2.0 * mu * self.stiffening * second)
    }

    /// (g(y + b ΔQ) − g(y))/b, y = `exponent`, ΔQ = `change`: vanishes with ΔQ, and is ΔQ for b = 0.
    fn stiffening_difference(&self, exponent: f64, change: f64) -> f64 {
        let limit = self.stiffening_limit;
        let whole = self.stiffening * change;
        let last = exponent + whole;
        // Of the change of y what is below the limit; its rounding does not matter where the limit lies between, since the slopes
        // agree there.
        let inner = match (exponent < limit, last < limit) {
            (true, true) => whole,
            (false, false) => 0.0,
            (true, false) => limit - exponent,
            (false, true) => last - limit,
        };
        let share = if inner == whole { 1.0 } else { inner / whole };
        let beyond = (exponent - limit).max(0.0) + (last - limit).max(0.0);
        let below = exponent.min(limit).exp() * mean_exponential(inner) * share;
        change * (below + limit.exp() * (1.0 + 0.5 * beyond) * (1.0 - share))
    }
}

/// (eˣ − 1)/x, the mean of the exponential from 0 to x.
fn mean_exponential(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { x.exp_m1() / x }
}

impl Hyperelastic for FungNeoHookean {
    fn validate(&self) -> Result<()> {
        neo_hookean::validate(self.youngs_modulus, self.poissons_ratio)?;
        let (b, limit) = (self.stiffening, self.stiffening_limit);
        if !(b >= 0.0 && b.is_finite()) {
            let problem = format!("{b}; must be finite and not negative (0 does not stiffen)");
            return Err(Error::invalid("material.stiffening", problem));
        }
        if !(limit > 0.0 && limit <= MOST_STIFFENING_LIMIT) {
            let problem = format!(
                "{limit}; must be above 0 and at most {MOST_STIFFENING_LIMIT}: tissue is {:.0e} times as stiff there",
                MOST_STIFFENING_LIMIT.exp()
            );
            return Err(Error::invalid("material.stiffening_limit", problem));
        }
        Ok(())
    }

    fn is_isotropic(&self) -> bool {
        true
    }

    fn energy_density(&self, f: DMat3) -> f64 {
        let NeoHookean { mu, lambda } = self.ground();
        let h = f - DMat3::IDENTITY;
        let volume = neo_hookean::volume_change(h);
        let stiffening = self.stiffening_difference(0.0, neo_hookean::strain(h));
        0.5 * mu * stiffening + 0.5 * lambda * volume * volume
    }

    fn energy_difference(&self, f: DMat3, d: DMat3) -> f64 {
        let NeoHookean { mu, lambda } = self.ground();
        let change = Differences::new(f, d);
        let exponent = self.exponent(f - DMat3::IDENTITY);
        0.5 * mu * self.stiffening_difference(exponent, change.strain())
            + 0.5 * lambda * change.square()
    }

    fn pk1_stress(&self, f: DMat3) -> DMat3 {
        self.stiffened(f).0.pk1_stress(f)
    }

    fn tangent(&self, f: DMat3) -> Mat9 {
        let (law, growth) = self.stiffened(f);
        law.tangent(f, growth)
    }

    fn projected_tangent(&self, f: DMat3) -> Mat9 {
        let (law, growth) = self.stiffened(f);
        law.projected_tangent(f, growth)
    }

    #[cfg(feature = "gpu")]
    fn parameters(&self) -> SharedValue {
        let (mu, lambda) = self.lame();
        let parameters = FungNeoHookeanParameters {
            mu: mu as f32,
            lambda: lambda as f32,
            stiffening: self.stiffening as f32,
            stiffening_limit: self.stiffening_limit as f32,
        };
        parameters.into()
    }

    fn kernels(&self) -> &'static [&'static str] {
        &[
            "shared/neo_hookean.wgsl",
            "shared/neo_hookean_modes.wgsl",
            "shared/exponential.wgsl",
            "material/fung_neo_hookean.wgsl",
        ]
    }
}
