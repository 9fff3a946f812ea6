//! Stable neo-Hookean elasticity.
//!
//! With I_C = F : F, J = det F and cof F = ∂J/∂F:
//!
//! ```text
//! Ψ = μ/2 (I_C − 3) − μ (J − 1) + (λ + μ)/2 (J − 1)²
//! P = μ (F − cof F) + (λ + μ)(J − 1) cof F
//! C = μ I₉ + (λ + μ) vec(cof F) vec(cof F)ᵀ + ((λ + μ)(J − 1) − μ) ∂cof F/∂F
//! ```
//!
//! Smith, de Goes and Kim, "Stable Neo-Hookean Flesh Simulation", 2018, without the logarithmic term
//! and with λ + μ for their λ, so that the linearisation at rest is isotropic elasticity of the Lamé
//! parameters μ = E/(2(1 + ν)), λ = Eν/((1 + ν)(1 − 2ν)). It is finite for inverted elements.

use super::Hyperelastic;
#[cfg(feature = "gpu")]
use crate::gpu::{SharedValue, host_shareable};
use crate::math::{
    Mat9, SingularValues, cofactor, double_dot, flatten, singular_values, skew, symmetric_eigen,
};
use crate::{Error, Result};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_1_SQRT_2;

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
        let (e, nu) = (self.youngs_modulus, self.poissons_ratio);
        (
            e / (2.0 * (1.0 + nu)),
            e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
        )
    }
}

/// J − 1 of F = I + H without the cancellation: tr H + tr cof H + det H.
fn volume_change(h: DMat3) -> f64 {
    trace(h) + trace(cofactor(h)) + h.determinant()
}

/// F − cof F of F = I + H without the cancellation: H + Hᵀ − tr H I − cof H.
fn shear_stress(h: DMat3) -> DMat3 {
    h + h.transpose() - DMat3::from_diagonal(DVec3::splat(trace(h))) - cofactor(h)
}

fn trace(m: DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

impl Hyperelastic for StableNeoHookean {
    fn validate(&self) -> Result<()> {
        let (e, nu) = (self.youngs_modulus, self.poissons_ratio);
        if !(e > 0.0 && e.is_finite()) {
            return Err(Error::invalid(
                "material.youngs_modulus",
                format!("{e}; must be positive (Pa)"),
            ));
        }
        if !(nu > -1.0 && nu < 0.5) {
            return Err(Error::invalid(
                "material.poissons_ratio",
                format!("{nu}; must be in (−1, 0.5): for nearly incompressible tissue take 0.49"),
            ));
        }
        Ok(())
    }

    fn is_isotropic(&self) -> bool {
        true
    }

    fn energy_density(&self, f: DMat3) -> f64 {
        let (mu, lambda) = self.lame();
        let h = f - DMat3::IDENTITY;
        let volume = volume_change(h);
        // I_C − 3 − 2 (J − 1) = H : H − 2 tr cof H − 2 det H
        let shear = double_dot(h, h) - 2.0 * (trace(cofactor(h)) + h.determinant());
        0.5 * mu * shear + 0.5 * (lambda + mu) * volume * volume
    }

    /// With D = ΔF and ΔJ = cof F : D + F : cof D + det D,
    /// ΔΨ = μ ((F − cof F) : D + ½ D : D − F : cof D − det D) + (λ + μ)/2 ΔJ (2 (J − 1) + ΔJ).
    fn energy_difference(&self, f: DMat3, d: DMat3) -> f64 {
        let (mu, lambda) = self.lame();
        let h = f - DMat3::IDENTITY;
        let higher = double_dot(f, cofactor(d)) + d.determinant();
        let volume_difference = double_dot(cofactor(f), d) + higher;
        let shear = double_dot(shear_stress(h), d) + 0.5 * double_dot(d, d) - higher;
        mu * shear
            + 0.5 * (lambda + mu) * volume_difference * (2.0 * volume_change(h) + volume_difference)
    }

    fn pk1_stress(&self, f: DMat3) -> DMat3 {
        let (mu, lambda) = self.lame();
        let h = f - DMat3::IDENTITY;
        mu * shear_stress(h) + (lambda + mu) * volume_change(h) * cofactor(f)
    }

    fn tangent(&self, f: DMat3) -> Mat9 {
        let (mu, lambda) = self.lame();
        let pressure = (lambda + mu) * volume_change(f - DMat3::IDENTITY) - mu;
        let cof = flatten(cofactor(f));
        let mut c = [[0.0; 9]; 9];
        for i in 0..9 {
            for j in 0..9 {
                c[i][j] = (lambda + mu) * cof[i] * cof[j];
            }
            c[i][i] += mu;
        }
        // Column k of cof F is f_i × f_j, (i, j, k) cyclic: its derivative by f_j is [f_i]×, by f_i −[f_j]×.
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            let (by_i, by_j) = (skew(f.col(j)), skew(f.col(i)));
            for column in 0..3 {
                for row in 0..3 {
                    c[3 * k + row][3 * j + column] += pressure * by_j.col(column)[row];
                    c[3 * k + row][3 * i + column] -= pressure * by_i.col(column)[row];
                }
            }
        }
        c
    }

    /// In the frame of F = U diag(σ) Vᵀ the eigenvectors are known (Smith et al. 2018, §4.5): with p the factor
    /// of ∂cof F/∂F, twists U (e_i e_jᵀ − e_j e_iᵀ) Vᵀ/√2 have μ + p σ_k, flips (with +) have μ − p σ_k,
    /// and the three scalings U diag(a) Vᵀ share a 3×3 matrix. Only negative ones are taken out of C.
    fn projected_tangent(&self, f: DMat3) -> Mat9 {
        let (mu, lambda) = self.lame();
        let pressure = (lambda + mu) * volume_change(f - DMat3::IDENTITY) - mu;
        let SingularValues { u, sigma, v } = singular_values(f);
        let mode = |i: usize, j: usize| {
            let (a, b) = (u.col(i), v.col(j));
            DMat3::from_cols(a * b.x, a * b.y, a * b.z)
        };
        let mut c = self.tangent(f);
        for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            let (twist, flip) = (mu + pressure * sigma[k], mu - pressure * sigma[k]);
            if twist < 0.0 {
                remove(&mut c, twist, (mode(i, j) - mode(j, i)) * FRAC_1_SQRT_2);
            }
            if flip < 0.0 {
                remove(&mut c, flip, (mode(i, j) + mode(j, i)) * FRAC_1_SQRT_2);
            }
        }
        let areas = DVec3::new(sigma.y * sigma.z, sigma.z * sigma.x, sigma.x * sigma.y);
        let mut scaling = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                scaling[i][j] = (lambda + mu) * areas[i] * areas[j]
                    + if i == j {
                        mu
                    } else {
                        pressure * sigma[3 - i - j]
                    };
            }
        }
        if !is_positive_definite(&scaling) {
            let (values, vectors) = symmetric_eigen(DMat3::from_cols_array_2d(&scaling));
            for k in 0..3 {
                if values[k] < 0.0 {
                    let a = vectors.col(k);
                    let direction = a.x * mode(0, 0) + a.y * mode(1, 1) + a.z * mode(2, 2);
                    remove(&mut c, values[k], direction);
                }
            }
        }
        c
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
            "material/stable_neo_hookean.wgsl",
        ]
    }
}

/// Sylvester's criterion, which spares most points the eigenvalues.
fn is_positive_definite(m: &[[f64; 3]; 3]) -> bool {
    let minor = m[0][0] * m[1][1] - m[0][1] * m[0][1];
    m[0][0] > 0.0 && minor > 0.0 && DMat3::from_cols_array_2d(m).determinant() > 0.0
}

/// C −= eigenvalue · q qᵀ.
fn remove(c: &mut Mat9, eigenvalue: f64, direction: DMat3) {
    let q = flatten(direction);
    for i in 0..9 {
        for j in 0..9 {
            c[i][j] -= eigenvalue * (q[i] * q[j]);
        }
    }
}
