//! Orthotropic, saturating tissue.
//!
//! With E = ½ (Fᵀ F − I) in the material's axes (normal to the skin, along the bone, around it), ∘ the product by
//! entries, and Ψ₀ the stable neo-Hookean ground substance ([`StableNeoHookean`]), which keeps volume and resists collapse:
//!
//! ```text
//! Ψ = Ψ₀(F) + ½ E : (K ∘ E) + (c/2) g(Q)      Q = E : (A ∘ E)      g(Q) = e^Q − 1                     Q ≤ Q_max
//!                                                                 g(Q) = e^Q_max (1 + Q − Q_max) − 1   beyond
//! S = K ∘ E + c g′ A ∘ E      P = P₀ + F S      g′ = e^min(Q, Q_max)
//! ```
//!
//! The orthotropic term is ½ E : C_orth : E of Li and Barbič, "Stable Orthotropic Materials", 2014, with their shear
//! moduli G_ij = √(E_i E_j)/(2 (1 + ν)) and ν = 0, since the ground substance has Poisson's effect already: K_ij =
//! √(k_i k_j), so that three moduli say it all and E : (K ∘ E) = |√[4]k ∘ E ∘ √[4]k|² is never negative. Fung's exponential
//! (Fung, Fronek and Patitucci 1979) has A_ij = √(a_i a_j) likewise. Past Q_max it goes on linearly in Q with the slope that
//! it has there: energy and stress stay continuous, stiffness stops growing (that is the clamp) and falls to c e^Q_max A.
//!
//! C = I ⊗ S + (F ⊗ I) ∂S/∂E (F ⊗ I)ᵀ + C₀ is projected as a whole ([`positive_part`]): the sum of parts projected one by
//! one would be positive semi-definite too, but stiffer than need be wherever compression makes S negative and C₀ outweighs it.

use super::{Hyperelastic, StableNeoHookean};
#[cfg(feature = "gpu")]
use crate::gpu::{SharedValue, host_shareable};
use crate::math::{Mat9, double_dot, positive_part};
use crate::{Error, Result};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// Past this e^Q_max kernels would overflow.
const MOST_SATURATION_LIMIT: f64 = 30.0;

/// Ψ = Ψ₀ + ½ E : (K ∘ E) + (c/2)(e^Q − 1), Q = E : (A ∘ E), linear past Q_max. Three numbers are: normal to the skin,
/// along the bone, around it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Orthotropic {
    /// Young's modulus of the ground substance, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio of the ground substance, in (−1, 0.5).
    pub poissons_ratio: f64,
    /// k, Pa: what fibres add to the stiffness along each axis; 0 or more.
    pub fibre_moduli: [f64; 3],
    /// c, Pa: size of the saturating term; 0 switches it off. It adds c a to the stiffness at rest.
    pub saturation: f64,
    /// a: how soon the term saturates along each axis, by e at a Green strain of 1/√a; 0 or more.
    pub saturation_rates: [f64; 3],
    /// Q_max, in 0..=30, past which the term goes on without growing stiffer.
    pub saturation_limit: f64,
}

impl Default for Orthotropic {
    /// Subcutaneous tissue with its skin: 10 kPa across, half as stiff again in the skin's plane, and stiffening from a stretch
    /// of about 1.3 on. A bar of it pressed to 40 % loses 35 % of its volume, 15 % of the ground substance alone (ν = 0.45).
    fn default() -> Self {
        Self {
            youngs_modulus: 1e4,
            poissons_ratio: 0.45,
            fibre_moduli: [500.0, 4e3, 2e3],
            saturation: 500.0,
            saturation_rates: [2.0, 4.0, 4.0],
            saturation_limit: 3.0,
        }
    }
}

#[cfg(feature = "gpu")]
host_shareable! {
    /// What the kernel reads (kernels/material/orthotropic.wgsl).
    pub struct OrthotropicParameters {
        /// μ of the ground substance, Pa.
        pub mu: f32,
        /// λ of the ground substance, Pa.
        pub lambda: f32,
        /// c, Pa.
        pub saturation: f32,
        /// Q_max.
        pub saturation_limit: f32,
        /// √k, √Pa.
        pub root_fibre_moduli: [f32; 3],
        /// Padding.
        pub _pad0: u32,
        /// √a.
        pub root_saturation_rates: [f32; 3],
        /// Padding.
        pub _pad1: u32,
    }
}

/// The fibres' answer to a strain.
struct Fibres {
    /// W = K + c g′ A.
    moduli: DMat3,
    /// S = W ∘ E, Pa.
    stress: DMat3,
    /// A ∘ E.
    direction: DMat3,
    /// c g″ = c e^Q, Pa; 0 past the limit.
    growth: f64,
}

impl Orthotropic {
    /// Ψ₀.
    pub fn ground(&self) -> StableNeoHookean {
        StableNeoHookean {
            youngs_modulus: self.youngs_modulus,
            poissons_ratio: self.poissons_ratio,
        }
    }

    fn fibres(&self, strain: DMat3) -> Fibres {
        let rates = square_roots(self.saturation_rates);
        let direction = by_entries(rates, strain);
        let q = double_dot(direction, strain);
        let slope = self.saturation * q.min(self.saturation_limit).exp();
        let moduli = square_roots(self.fibre_moduli) + rates * slope;
        Fibres {
            moduli,
            stress: by_entries(moduli, strain),
            direction,
            growth: if q < self.saturation_limit {
                slope
            } else {
                0.0
            },
        }
    }
}

/// The matrix of √(d_i d_j).
fn square_roots(d: [f64; 3]) -> DMat3 {
    let root = DVec3::from_array(d.map(f64::sqrt));
    DMat3::from_cols(root * root.x, root * root.y, root * root.z)
}

/// A ∘ B.
fn by_entries(a: DMat3, b: DMat3) -> DMat3 {
    DMat3::from_cols(
        a.x_axis * b.x_axis,
        a.y_axis * b.y_axis,
        a.z_axis * b.z_axis,
    )
}

/// ½ (M + Mᵀ).
fn symmetric_part(m: DMat3) -> DMat3 {
    (m + m.transpose()) * 0.5
}

/// E of F = I + H without the cancellation: ½ (H + Hᵀ + Hᵀ H).
fn green_strain(h: DMat3) -> DMat3 {
    symmetric_part(h) + h.transpose() * h * 0.5
}

/// g(Q₀ + ΔQ) − g(Q₀) without the cancellation. `inner` is the part of ΔQ below the limit; where the limit lies between,
/// its rounding does not matter, since both slopes agree there.
fn saturation_difference(q: f64, change: f64, limit: f64) -> f64 {
    let (from, to) = (q, q + change);
    let inner = match (from < limit, to < limit) {
        (true, true) => change,
        (false, false) => 0.0,
        (true, false) => limit - from,
        (false, true) => to - limit,
    };
    from.min(limit).exp() * inner.exp_m1() + limit.exp() * (change - inner)
}

impl Hyperelastic for Orthotropic {
    fn validate(&self) -> Result<()> {
        self.ground().validate()?;
        let not_negative = |values: &[f64], field: &str, unit: &str| {
            let ok = values.iter().all(|&v| v >= 0.0 && v.is_finite());
            ok.then_some(()).ok_or_else(|| {
                let problem = format!("{values:?}; none may be negative{unit}");
                Error::invalid(format!("material.{field}"), problem)
            })
        };
        not_negative(&self.fibre_moduli, "fibre_moduli", " (Pa)")?;
        not_negative(&[self.saturation], "saturation", " (Pa)")?;
        not_negative(&self.saturation_rates, "saturation_rates", "")?;
        let limit = self.saturation_limit;
        if !(0.0..=MOST_SATURATION_LIMIT).contains(&limit) {
            let problem = format!(
                "{limit}; must be in 0..={MOST_SATURATION_LIMIT}: tissue is {:.0e} times as stiff there",
                MOST_SATURATION_LIMIT.exp()
            );
            return Err(Error::invalid("material.saturation_limit", problem));
        }
        Ok(())
    }

    fn is_isotropic(&self) -> bool {
        false
    }

    fn energy_density(&self, f: DMat3) -> f64 {
        let e = green_strain(f - DMat3::IDENTITY);
        let fibres = 0.5 * double_dot(e, by_entries(square_roots(self.fibre_moduli), e));
        let q = double_dot(e, by_entries(square_roots(self.saturation_rates), e));
        let saturating = saturation_difference(0.0, q, self.saturation_limit);
        self.ground().energy_density(f) + fibres + 0.5 * self.saturation * saturating
    }

    /// ΔE = sym(Fᵀ D) + ½ Dᵀ D, and each quadratic form changes by ΔE : (M ∘ (2 E + ΔE)).
    fn energy_difference(&self, f: DMat3, d: DMat3) -> f64 {
        let e = green_strain(f - DMat3::IDENTITY);
        let change = symmetric_part(f.transpose() * d) + d.transpose() * d * 0.5;
        let rates = square_roots(self.saturation_rates);
        let between = e * 2.0 + change;
        let fibres = double_dot(change, by_entries(square_roots(self.fibre_moduli), between));
        let q = double_dot(e, by_entries(rates, e));
        let q_change = double_dot(change, by_entries(rates, between));
        let saturating = saturation_difference(q, q_change, self.saturation_limit);
        self.ground().energy_difference(f, d) + 0.5 * (fibres + self.saturation * saturating)
    }

    fn pk1_stress(&self, f: DMat3) -> DMat3 {
        let strain = green_strain(f - DMat3::IDENTITY);
        self.ground().pk1_stress(f) + f * self.fibres(strain).stress
    }

    /// With f_i the columns of F, the block of columns i and j is
    /// C_ij = S_ij I + ½ W_ij f_j f_iᵀ + ½ δ_ij Σ_m W_mi f_m f_mᵀ + 2 c g″ t_i t_jᵀ, t = F (A ∘ E).
    fn tangent(&self, f: DMat3) -> Mat9 {
        let Fibres {
            moduli,
            stress,
            direction,
            growth,
        } = self.fibres(green_strain(f - DMat3::IDENTITY));
        let t = f * direction;
        let mut c = self.ground().tangent(f);
        for i in 0..3 {
            for j in 0..3 {
                let (fi, fj, ti, tj) = (f.col(i), f.col(j), t.col(i), t.col(j));
                for row in 0..3 {
                    for column in 0..3 {
                        let mut entry = 0.5 * moduli.col(i)[j] * fj[row] * fi[column]
                            + 2.0 * growth * ti[row] * tj[column];
                        if row == column {
                            entry += stress.col(i)[j];
                        }
                        if i == j {
                            let sum =
                                (0..3).map(|m| moduli.col(i)[m] * f.col(m)[row] * f.col(m)[column]);
                            entry += 0.5 * sum.sum::<f64>();
                        }
                        c[3 * i + row][3 * j + column] += entry;
                    }
                }
            }
        }
        c
    }

    fn projected_tangent(&self, f: DMat3) -> Mat9 {
        positive_part(&self.tangent(f))
    }

    #[cfg(feature = "gpu")]
    fn parameters(&self) -> SharedValue {
        let (mu, lambda) = self.ground().lame();
        let roots = |values: [f64; 3]| values.map(|v| v.sqrt() as f32);
        let parameters = OrthotropicParameters {
            mu: mu as f32,
            lambda: lambda as f32,
            saturation: self.saturation as f32,
            saturation_limit: self.saturation_limit as f32,
            root_fibre_moduli: roots(self.fibre_moduli),
            root_saturation_rates: roots(self.saturation_rates),
            ..OrthotropicParameters::default()
        };
        parameters.into()
    }

    fn kernels(&self) -> &'static [&'static str] {
        &[
            "shared/neo_hookean.wgsl",
            "shared/positive_part.wgsl",
            "shared/exponential.wgsl",
            "material/orthotropic.wgsl",
        ]
    }
}
