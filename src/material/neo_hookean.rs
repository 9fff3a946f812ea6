//! The neo-Hookean ground of isotropic tissue, by its Lamé parameters.
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
//!
//! Sorted by parameters it is Ψ = μ/2 Q + λ/2 (J − 1)² with
//!
//! ```text
//! Q = I_C − 4J + J² = |F|² − 3 − 2 (J − 1) + (J − 1)²      ½ ∂Q/∂F = A = F − cof F + (J − 1) cof F
//! ```
//!
//! which is 0 for rotations and positive else (but for F = 0): a μ that grows with Q stiffens the tissue, and a part
//! a A ⊗ A in C is all that this adds ([`super::FungNeoHookean`]).

use crate::math::{
    Mat9, SingularValues, cofactor, double_dot, flatten, singular_values, skew, symmetric_eigen,
};
use crate::{Error, Result};
use glam::{DMat3, DVec3};
use std::f64::consts::FRAC_1_SQRT_2;

/// Lamé's parameters, Pa.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct NeoHookean {
    pub mu: f64,
    pub lambda: f64,
}

/// Checks E and ν; an error names the one at fault.
pub(super) fn validate(youngs_modulus: f64, poissons_ratio: f64) -> Result<()> {
    let (e, nu) = (youngs_modulus, poissons_ratio);
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

/// J − 1 of F = I + H without the cancellation: tr H + tr cof H + det H.
pub(super) fn volume_change(h: DMat3) -> f64 {
    trace(h) + trace(cofactor(h)) + h.determinant()
}

/// F − cof F of F = I + H without the cancellation: H + Hᵀ − tr H I − cof H.
fn shear_stress(h: DMat3) -> DMat3 {
    h + h.transpose() - DMat3::from_diagonal(DVec3::splat(trace(h))) - cofactor(h)
}

/// I_C − 3 − 2 (J − 1) of F = I + H without the cancellation: H : H − 2 tr cof H − 2 det H.
fn shear(h: DMat3) -> f64 {
    double_dot(h, h) - 2.0 * (trace(cofactor(h)) + h.determinant())
}

/// Q of F = I + H.
pub(super) fn strain(h: DMat3) -> f64 {
    let volume = volume_change(h);
    shear(h) + volume * volume
}

fn trace(m: DMat3) -> f64 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

/// What changes from F to F + D, each from terms that vanish with D.
pub(super) struct Differences {
    /// ½ Δ(I_C − 2J).
    half_shear: f64,
    /// ΔJ.
    volume: f64,
    /// 2 (J − 1) + ΔJ.
    twice_mean: f64,
}

impl Differences {
    /// With ΔJ = cof F : D + s, s = F : cof D + det D:  ½ Δ(I_C − 2J) = (F − cof F) : D + ½ D : D − s.
    pub fn new(f: DMat3, d: DMat3) -> Self {
        let h = f - DMat3::IDENTITY;
        let higher = double_dot(f, cofactor(d)) + d.determinant();
        let volume = double_dot(cofactor(f), d) + higher;
        Self {
            half_shear: double_dot(shear_stress(h), d) + 0.5 * double_dot(d, d) - higher,
            volume,
            twice_mean: 2.0 * volume_change(h) + volume,
        }
    }

    /// Δ(J − 1)².
    pub fn square(&self) -> f64 {
        self.volume * self.twice_mean
    }

    /// ΔQ.
    pub fn strain(&self) -> f64 {
        2.0 * self.half_shear + self.square()
    }
}

impl NeoHookean {
    /// Of Young's modulus, Pa, and Poisson's ratio.
    pub fn new(youngs_modulus: f64, poissons_ratio: f64) -> Self {
        let (e, nu) = (youngs_modulus, poissons_ratio);
        Self {
            mu: e / (2.0 * (1.0 + nu)),
            lambda: e * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)),
        }
    }

    /// Ψ(F), Pa.
    pub fn energy_density(self, f: DMat3) -> f64 {
        let h = f - DMat3::IDENTITY;
        let volume = volume_change(h);
        0.5 * self.mu * shear(h) + 0.5 * (self.lambda + self.mu) * volume * volume
    }

    /// Ψ(F + D) − Ψ(F), Pa.
    pub fn energy_difference(self, f: DMat3, d: DMat3) -> f64 {
        let change = Differences::new(f, d);
        self.mu * change.half_shear
            + 0.5 * (self.lambda + self.mu) * change.volume * change.twice_mean
    }

    /// P, Pa.
    pub fn pk1_stress(self, f: DMat3) -> DMat3 {
        let h = f - DMat3::IDENTITY;
        self.mu * shear_stress(h) + (self.lambda + self.mu) * volume_change(h) * cofactor(f)
    }

    /// p = (λ + μ)(J − 1) − μ, the factor of ∂cof F/∂F.
    fn pressure(self, f: DMat3) -> f64 {
        (self.lambda + self.mu) * volume_change(f - DMat3::IDENTITY) - self.mu
    }

    /// C + a A ⊗ A, Pa, a being the `growth`, 0 or more.
    pub fn tangent(self, f: DMat3, growth: f64) -> Mat9 {
        let kappa = self.lambda + self.mu;
        let pressure = self.pressure(f);
        let areas = cofactor(f);
        let cof = flatten(areas);
        let mut c = [[0.0; 9]; 9];
        for i in 0..9 {
            for j in 0..9 {
                c[i][j] = kappa * cof[i] * cof[j];
            }
            c[i][i] += self.mu;
        }
        if growth != 0.0 {
            let h = f - DMat3::IDENTITY;
            let a = flatten((shear_stress(h) + areas * volume_change(h)) * growth.sqrt());
            for i in 0..9 {
                for j in 0..9 {
                    c[i][j] += a[i] * a[j];
                }
            }
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

    /// C + a A ⊗ A without its negative eigenvalues, Pa, a being the `growth`, 0 or more.
    ///
    /// In the frame of F = U diag(σ) Vᵀ the eigenvectors are known (Smith et al. 2018, §4.5): with p the factor
    /// of ∂cof F/∂F, twists U (e_i e_jᵀ − e_j e_iᵀ) Vᵀ/√2 have μ + p σ_k, flips (with +) have μ − p σ_k,
    /// and the three scalings U diag(a) Vᵀ share a 3×3 matrix. A is a scaling. Only negative ones are taken out of C.
    pub fn projected_tangent(self, f: DMat3, growth: f64) -> Mat9 {
        let Self { mu, lambda } = self;
        let volume = volume_change(f - DMat3::IDENTITY);
        let pressure = (lambda + mu) * volume - mu;
        let SingularValues { u, sigma, v } = singular_values(f);
        let mode = |i: usize, j: usize| {
            let (a, b) = (u.col(i), v.col(j));
            DMat3::from_cols(a * b.x, a * b.y, a * b.z)
        };
        let mut c = self.tangent(f, growth);
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
        let gradient = sigma + areas * (volume - 1.0);
        let mut scaling = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                scaling[i][j] = (lambda + mu) * areas[i] * areas[j]
                    + growth * (gradient[i] * gradient[j])
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
