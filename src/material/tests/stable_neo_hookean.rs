//! Stable neo-Hookean: isotropic elasticity at rest, uniaxial tension.

use super::largest;
use crate::material::{Hyperelastic, Material, StableNeoHookean};
use crate::math::{Random, contract};
use approx::assert_relative_eq;
use glam::{DMat3, DVec3};

#[test]
fn stable_neo_hookean_at_rest_is_isotropic_elasticity() {
    let random = &mut Random::new(6);
    for (youngs_modulus, poissons_ratio) in [(3e4, 0.45), (1e6, 0.0), (5e3, 0.49)] {
        let model = StableNeoHookean {
            youngs_modulus,
            poissons_ratio,
        };
        let (mu, lambda) = model.lame();
        // E = μ(3λ + 2μ)/(λ + μ), ν = λ/(2(λ + μ))
        assert_relative_eq!(
            mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu),
            youngs_modulus,
            max_relative = 1e-12
        );
        assert_relative_eq!(
            lambda / (2.0 * (lambda + mu)),
            poissons_ratio,
            epsilon = 1e-12
        );
        let c = model.tangent(DMat3::IDENTITY);
        let h = random.matrix(1.0);
        let trace = h.x_axis.x + h.y_axis.y + h.z_axis.z;
        let hooke = (h + h.transpose()) * mu + DMat3::from_diagonal(DVec3::splat(lambda * trace));
        assert!(largest(contract(&c, h) - hooke) < 1e-12 * (lambda + mu));
        for i in 0..9 {
            for j in 0..9 {
                assert_eq!(c[i][j], c[j][i]);
            }
        }
    }
}

#[test]
fn stable_neo_hookean_in_uniaxial_tension() {
    let model = StableNeoHookean {
        youngs_modulus: 3e4,
        poissons_ratio: 0.3,
    };
    let (mu, lambda) = model.lame();
    // Along x with the sides held: F = diag(s, 1, 1), cof F = diag(1, s, s).
    for s in [0.4, 0.9, 1.0, 1.3, 2.0] {
        let p = model.pk1_stress(DMat3::from_diagonal(DVec3::new(s, 1.0, 1.0)));
        assert_relative_eq!(p.x_axis.x, (lambda + 2.0 * mu) * (s - 1.0), epsilon = 1e-9);
        let side = (mu * (1.0 - s)) + (lambda + mu) * (s - 1.0) * s;
        assert_relative_eq!(p.y_axis.y, side, epsilon = 1e-9);
    }
    // With the sides free and a small stretch: σ = E ε and the sides shrink by ν ε.
    let strain = 1e-6;
    let side = 1.0 - 0.3 * strain;
    let p = model.pk1_stress(DMat3::from_diagonal(DVec3::new(1.0 + strain, side, side)));
    assert_relative_eq!(p.x_axis.x, 3e4 * strain, max_relative = 1e-4);
    assert!(p.y_axis.y.abs() < 1e-4 * p.x_axis.x);
}

#[test]
fn unusable_parameters_are_refused_by_name() {
    for (youngs_modulus, poissons_ratio, field) in [
        (0.0, 0.3, "youngs_modulus"),
        (f64::NAN, 0.3, "youngs_modulus"),
        (1e4, 0.5, "poissons_ratio"),
        (1e4, -1.0, "poissons_ratio"),
        (1e4, f64::NAN, "poissons_ratio"),
    ] {
        let material = Material::StableNeoHookean(StableNeoHookean {
            youngs_modulus,
            poissons_ratio,
        });
        let message = material.validate().unwrap_err().to_string();
        assert!(message.contains(field), "{message}");
    }
    for material in Material::examples() {
        material.validate().unwrap();
        assert!(material.kernels().iter().all(|k| k.ends_with(".wgsl")));
    }
}
