//! What every material must satisfy: stress and tangent are derivatives, projection, rotations.

use super::largest;
use crate::material::Material;
use crate::math::{Random, contract, double_dot, flatten, unflatten};
use approx::assert_relative_eq;
use faer::{Mat, Side};
use glam::{DMat3, DVec3};

/// The largest entry of the tangent at `f`, or at rest where that is larger: what errors are measured by, since laws with an
/// exponential are far stiffer at some samples than at others.
pub fn stiffness(material: &Material, f: DMat3) -> f64 {
    let entries = [f, DMat3::IDENTITY].map(|f| material.tangent(f));
    let entries = entries.iter().flatten().flatten();
    entries.fold(0.0, |largest, c| largest.max(c.abs()))
}

/// Deformation gradients from mild to inverted, and one pressed flat.
pub fn samples(random: &mut Random) -> Vec<DMat3> {
    let mut all: Vec<_> = [0.05, 0.4, 1.2]
        .into_iter()
        .flat_map(|size| [size; 40])
        .map(|size| DMat3::IDENTITY + random.matrix(size))
        .collect();
    all.push(DMat3::from_diagonal(DVec3::new(1.1, 0.7, 0.3)));
    all.push(DMat3::from_diagonal(DVec3::new(1.0, 0.9, -0.4)));
    all
}

#[test]
fn stress_is_the_gradient_of_the_energy() {
    let random = &mut Random::new(1);
    let step = 1e-5;
    for material in Material::examples() {
        for f in samples(random) {
            let scale = stiffness(&material, f);
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
        for f in samples(random) {
            let scale = stiffness(&material, f);
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
        for f in samples(random) {
            let scale = stiffness(&material, f);
            let change = random.matrix(0.3);
            let expected = material.energy_density(f + change) - material.energy_density(f);
            let difference = material.energy_difference(f, change);
            let size = material.energy_density(f).abs() + expected.abs();
            assert_relative_eq!(
                difference,
                expected,
                epsilon = 1e-13 * (scale + size),
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
        let mut indefinite = 0;
        for f in samples(random) {
            let scale = stiffness(&material, f);
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
        for f in samples(random) {
            let scale = stiffness(&material, f);
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
fn tangents_act_on_flattened_columns() {
    let m = DMat3::from_cols_array(&std::array::from_fn(|k| k as f64));
    assert_eq!(unflatten(&flatten(m)), m);
    assert_eq!(flatten(m)[3], m.col(1).x);
}
