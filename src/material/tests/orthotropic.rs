//! Fibres that saturate: closed forms, the clamp, axes and stiffness of a point.

use super::largest;
use super::laws::{samples, stiffness};
use crate::material::{Hyperelastic, LocalTissue, Material, Orthotropic};
use crate::math::{Random, contract, double_dot};
use approx::assert_relative_eq;
use glam::{DMat3, DVec3};

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
        for f in samples(random) {
            let scale = 1.7 * stiffness(&material, f);
            let axes = random.rotation(3.0);
            let point = material.at(LocalTissue {
                stiffness: 1.7,
                axes: glam::DQuat::from_mat3(&axes).normalize(),
                ..LocalTissue::default()
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
                ..LocalTissue::default()
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
