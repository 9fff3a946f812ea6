//! What every material must satisfy, and what this one is known to give.

use super::*;
use crate::math::{Random, contract, double_dot, flatten, unflatten};
use approx::assert_relative_eq;
use faer::{Mat, Side};
use glam::{DMat3, DVec3};

/// Deformation gradients from mild to inverted, and one pressed flat.
fn samples(random: &mut Random) -> Vec<DMat3> {
    let mut all: Vec<_> = [0.05, 0.4, 1.2]
        .into_iter()
        .flat_map(|size| [size; 40])
        .map(|size| DMat3::IDENTITY + random.matrix(size))
        .collect();
    all.push(DMat3::from_diagonal(DVec3::new(1.1, 0.7, 0.3)));
    all.push(DMat3::from_diagonal(DVec3::new(1.0, 0.9, -0.4)));
    all
}

fn largest(m: DMat3) -> f64 {
    m.to_cols_array()
        .iter()
        .fold(0.0, |a, x| f64::max(a, x.abs()))
}

#[test]
fn stress_is_the_gradient_of_the_energy() {
    let random = &mut Random::new(1);
    let step = 1e-5;
    for material in Material::examples() {
        let scale = material.tangent(DMat3::IDENTITY)[0][0];
        for f in samples(random) {
            let direction = random.matrix(1.0);
            let ahead = material.energy_density(f + direction * step);
            let behind = material.energy_density(f - direction * step);
            let expected = double_dot(material.pk1_stress(f), direction);
            // Ψ is of degree 6 in F: the third derivative is of the order of the stiffness.
            assert_relative_eq!(
                (ahead - behind) / (2.0 * step),
                expected,
                epsilon = 1e-6 * scale
            );
        }
    }
}

#[test]
fn tangent_is_the_gradient_of_the_stress() {
    let random = &mut Random::new(2);
    let step = 1e-5;
    for material in Material::examples() {
        let scale = material.tangent(DMat3::IDENTITY)[0][0];
        for f in samples(random) {
            let direction = random.matrix(1.0);
            let ahead = material.pk1_stress(f + direction * step);
            let behind = material.pk1_stress(f - direction * step);
            let expected = contract(&material.tangent(f), direction);
            let error = (ahead - behind) * (0.5 / step) - expected;
            assert!(largest(error) < 1e-6 * scale, "{f}: {error}");
        }
    }
}

#[test]
fn energy_difference_agrees_with_the_energies_and_keeps_its_digits() {
    let random = &mut Random::new(3);
    for material in Material::examples() {
        let scale = material.tangent(DMat3::IDENTITY)[0][0];
        for f in samples(random) {
            let change = random.matrix(0.3);
            let expected = material.energy_density(f + change) - material.energy_density(f);
            let difference = material.energy_difference(f, change);
            assert_relative_eq!(
                difference,
                expected,
                epsilon = 1e-13 * scale,
                max_relative = 1e-12
            );

            // A change far below the rounding of Ψ: first order is all there is.
            let tiny = change * 1e-14;
            let first_order = double_dot(material.pk1_stress(f), tiny);
            assert_relative_eq!(
                material.energy_difference(f, tiny),
                first_order,
                epsilon = 1e-26 * scale,
                max_relative = 1e-10
            );
        }
    }
}

#[test]
fn projected_tangent_is_the_tangent_with_negative_eigenvalues_removed() {
    let random = &mut Random::new(4);
    for material in Material::examples() {
        let scale = material.tangent(DMat3::IDENTITY)[0][0];
        let mut indefinite = 0;
        for f in samples(random) {
            let tangent = material.tangent(f);
            let dense = Mat::from_fn(9, 9, |i, j| tangent[i][j]);
            let eigen = dense.self_adjoint_eigen(Side::Lower).unwrap();
            let (vectors, values) = (eigen.U(), eigen.S());
            indefinite += usize::from((0..9).any(|k| values[k] < -1e-3 * scale));
            let projected = material.projected_tangent(f);
            for i in 0..9 {
                for j in 0..9 {
                    let expected: f64 = (0..9)
                        .map(|k| values[k].max(0.0) * vectors[(i, k)] * vectors[(j, k)])
                        .sum();
                    assert_relative_eq!(projected[i][j], expected, epsilon = 1e-7 * scale);
                }
            }
        }
        assert!(
            indefinite > 20,
            "only {indefinite} samples test the projection"
        );
    }
}

#[test]
fn energy_does_not_see_rotations_and_stress_turns_with_them() {
    let random = &mut Random::new(5);
    for material in Material::examples() {
        let scale = material.tangent(DMat3::IDENTITY)[0][0];
        for f in samples(random) {
            let r = random.rotation(2.0);
            let energy = material.energy_density(f);
            assert_relative_eq!(
                material.energy_density(r * f),
                energy,
                epsilon = 1e-13 * scale,
                max_relative = 1e-12
            );
            let turned = material.pk1_stress(r * f) - r * material.pk1_stress(f);
            assert!(largest(turned) < 1e-12 * scale * (1.0 + f.determinant().powi(2)));
        }
        assert_eq!(material.energy_density(DMat3::IDENTITY), 0.0);
        assert_eq!(material.pk1_stress(DMat3::IDENTITY), DMat3::ZERO);
    }
}

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

#[test]
fn tangents_act_on_flattened_columns() {
    let m = DMat3::from_cols_array(&std::array::from_fn(|k| k as f64));
    assert_eq!(unflatten(&flatten(m)), m);
    assert_eq!(flatten(m)[3], m.col(1).x);
}

/// Fibres along the second axis only.
fn one_family(saturation_limit: f64) -> Orthotropic {
    Orthotropic {
        youngs_modulus: 1e4,
        poissons_ratio: 0.4999,
        fibre_moduli: [0.0, 6e3, 0.0],
        saturation: 800.0,
        saturation_rates: [0.0, 5.0, 0.0],
        saturation_limit,
    }
}

/// The sides' stretches are those that leave the sides free.
fn uniaxial_stress(model: &Orthotropic, stretch: f64) -> f64 {
    let stress =
        |side: f64| model.pk1_stress(DMat3::from_diagonal(DVec3::new(side, stretch, side)));
    let (mut low, mut high) = (0.1, 3.0);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if stress(middle).x_axis.x > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    stress(low).y_axis.y
}

/// An incompressible bar has sides 1/√s, so that a neo-Hookean one pulls with μ (s − 1/s²); fibres along it add dW/ds
/// of W = ½ k E² + (c/2) g(a E²), E = (s² − 1)/2.
#[test]
fn orthotropic_in_uniaxial_tension_follows_the_closed_form() {
    for limit in [0.0_f64, 0.6, 2.0, 30.0] {
        let model = one_family(limit);
        let (mu, lambda) = model.ground().lame();
        for s in [0.5, 0.8, 1.0, 1.2, 1.5, 1.7] {
            let e: f64 = 0.5 * (s * s - 1.0);
            let slope = (5.0 * e * e).min(limit).exp();
            let fibres = s * e * (6e3 + 800.0 * 5.0 * slope);
            let expected = mu * (s - 1.0 / (s * s)) + fibres;
            // What is left of compressibility: the volume changes by some μ/λ.
            let error = uniaxial_stress(&model, s) - expected;
            assert!(
                error.abs() < 10.0 * mu / lambda * mu,
                "{limit} {s}: {error}"
            );
        }
    }
}

#[test]
fn the_clamp_keeps_energy_and_stress_continuous_and_bounds_their_growth() {
    let model = one_family(1.5);
    // Q = a E² reaches the limit here.
    let at = (1.0 + 2.0 * (1.5_f64 / 5.0).sqrt()).sqrt();
    let stretched = |s: f64| DMat3::from_diagonal(DVec3::new(1.0, s, 1.0));
    let (below, above) = (stretched(at - 1e-9), stretched(at + 1e-9));
    let jump = |a: f64, b: f64| (a - b).abs() / b.abs();
    assert!(jump(model.energy_density(below), model.energy_density(above)) < 1e-7);
    let (p, q) = (model.pk1_stress(below), model.pk1_stress(above));
    assert!(jump(p.y_axis.y, q.y_axis.y) < 1e-7);
    // The stiffness does jump: the exponential's own growth ends.
    let stiffness = |f| model.tangent(f)[4][4] - model.ground().tangent(f)[4][4];
    assert!(stiffness(below) > 1.5 * stiffness(above));
    // Past the limit the energy is a polynomial of degree 4 in s: doubling s multiplies it by 16 at most, in the end.
    let unclamped = one_family(30.0);
    let fibres = |m: &Orthotropic, s: f64| {
        m.energy_density(stretched(s)) - m.ground().energy_density(stretched(s))
    };
    let growth = |m: &Orthotropic| fibres(m, 4.0) / fibres(m, 2.0);
    assert!(growth(&model) < 40.0, "{}", growth(&model));
    assert!(growth(&unclamped) > 1e4, "{}", growth(&unclamped));
}

#[test]
fn fibres_add_their_moduli_to_the_stiffness_at_rest() {
    let model = Orthotropic::default();
    let random = &mut Random::new(7);
    let h = random.matrix(1.0);
    let strain = (h + h.transpose()) * 0.5;
    let added = contract(&model.tangent(DMat3::IDENTITY), h)
        - contract(&model.ground().tangent(DMat3::IDENTITY), h);
    for i in 0..3 {
        for j in 0..3 {
            let k = (model.fibre_moduli[i] * model.fibre_moduli[j]).sqrt();
            let a = (model.saturation_rates[i] * model.saturation_rates[j]).sqrt();
            let expected = (k + model.saturation * a) * strain.col(j)[i];
            assert_relative_eq!(added.col(j)[i], expected, epsilon = 1e-9 * 1e4);
        }
    }
}

#[test]
fn a_point_turns_the_material_and_scales_it() {
    let random = &mut Random::new(8);
    for material in Material::examples() {
        let scale = 1.7 * material.tangent(DMat3::IDENTITY)[0][0];
        for f in samples(random) {
            let axes = random.rotation(3.0);
            let point = material.at(LocalTissue {
                stiffness: 1.7,
                axes: glam::DQuat::from_mat3(&axes).normalize(),
            });
            // Seen from the material's axes the deformation gradient is F G; its own P has to be brought back.
            let expected = 1.7 * material.energy_density(f * axes);
            let room = scale * (1.0 + f.determinant().powi(2));
            assert_relative_eq!(
                point.energy_density(f),
                expected,
                epsilon = 1e-12 * room,
                max_relative = 1e-10
            );
            let p = material.pk1_stress(f * axes) * axes.transpose() * 1.7;
            let size = 1.0 + largest(p);
            assert!(largest(point.pk1_stress(f) - p) < 1e-10 * (size + room));
            let (change, step) = (random.matrix(1.0), 1e-5);
            let ahead = point.pk1_stress(f + change * step);
            let behind = point.pk1_stress(f - change * step);
            let error = (ahead - behind) * (0.5 / step) - contract(&point.tangent(f), change);
            assert!(largest(error) < 1e-6 * scale);
            let difference = point.energy_difference(f, change * 1e-14);
            let first_order = double_dot(point.pk1_stress(f), change * 1e-14);
            assert_relative_eq!(
                difference,
                first_order,
                epsilon = 1e-26 * scale,
                max_relative = 1e-10
            );
        }
    }
}

/// What has no axes and is as stiff as the material costs and changes nothing, not even the last bit.
#[test]
fn an_isotropic_point_of_its_own_stiffness_is_the_material_bit_for_bit() {
    let random = &mut Random::new(10);
    for material in Material::examples()
        .into_iter()
        .filter(Material::is_isotropic)
    {
        for f in samples(random) {
            let point = material.at(LocalTissue {
                stiffness: 1.0,
                axes: glam::DQuat::from_mat3(&random.rotation(3.0)).normalize(),
            });
            let change = random.matrix(0.1);
            assert_eq!(point.pk1_stress(f), material.pk1_stress(f));
            assert_eq!(point.projected_tangent(f), material.projected_tangent(f));
            let (own, plain) = (
                point.energy_difference(f, change),
                material.energy_difference(f, change),
            );
            assert_eq!(own.to_bits(), plain.to_bits());
        }
    }
}

#[test]
fn equal_moduli_have_no_axes() {
    let model = Material::Orthotropic(Orthotropic {
        fibre_moduli: [4e3; 3],
        saturation_rates: [6.0; 3],
        ..Orthotropic::default()
    });
    let random = &mut Random::new(9);
    for f in samples(random) {
        let turned = model.energy_density(f * random.rotation(3.0));
        assert_relative_eq!(turned, model.energy_density(f), max_relative = 1e-11);
    }
}

#[test]
fn unusable_fibres_are_refused_by_name() {
    let default = Orthotropic::default();
    for (broken, field) in [
        (
            Orthotropic {
                fibre_moduli: [1.0, -1.0, 0.0],
                ..default
            },
            "fibre_moduli",
        ),
        (
            Orthotropic {
                saturation: f64::NAN,
                ..default
            },
            "saturation",
        ),
        (
            Orthotropic {
                saturation_rates: [-1.0, 0.0, 0.0],
                ..default
            },
            "saturation_rates",
        ),
        (
            Orthotropic {
                saturation_limit: 31.0,
                ..default
            },
            "saturation_limit",
        ),
        (
            Orthotropic {
                saturation_limit: -0.1,
                ..default
            },
            "saturation_limit",
        ),
        (
            Orthotropic {
                poissons_ratio: 0.5,
                ..default
            },
            "poissons_ratio",
        ),
    ] {
        let message = Material::Orthotropic(broken)
            .validate()
            .unwrap_err()
            .to_string();
        assert!(message.contains(field), "{message}");
    }
    let read: Material = toml::from_str("orthotropic = { youngs_modulus = 2e4 }").unwrap();
    let expected = Orthotropic {
        youngs_modulus: 2e4,
        ..default
    };
    assert_eq!(read, Material::Orthotropic(expected));
    assert!(toml::from_str::<Material>("orthotropic = { stiffness = 1.0 }").is_err());
}
