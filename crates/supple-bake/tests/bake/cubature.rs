//! Cubature weights on tissue whose stiffness varies.

use super::{baked, recipe};
use glam::{DMat3, DVec3};
use supple::glam;
use supple::internal::math::Random;
use supple::model::Avatar;
use supple_bake::{HandleCandidates, Recipe, StiffnessRegion, Truncation, all_tets};
use supple_samples::Limb;

/// ½ Σ_i w_i s_i |Σ_h φ_h ∇U_hᵀ|², with the weights and points of `avatar` and the stiffness s of `map`'s points.
fn energy(avatar: &Avatar, map: &Avatar, phi: &[DVec3]) -> f64 {
    let points = &avatar.cubature;
    let of_point = |i: usize| {
        let terms = points.basis.row(i).iter();
        let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
        let slope = terms.map(|u| outer(phi[u.handle as usize], u.gradient));
        let slope = slope.fold(DMat3::ZERO, |sum, m| sum + m);
        let square: f64 = slope.to_cols_array().iter().map(|x| x * x).sum();
        0.5 * points.measure[i] * map.tissue[i].stiffness * square
    };
    (0..points.len()).map(of_point).sum()
}

/// Tissue ten times as stiff around the bone as under the skin: of the same points, the weights that know it miss
/// the energy of all tets by less, where handles move at random and where neighbours move together.
#[test]
fn weights_that_know_the_stiffness_give_the_energy_of_stiff_and_soft_tissue() {
    let body = Limb::S.body().unwrap();
    let even = Recipe {
        // Rows that keep the sway have slopes at the bone that so few points miss by as much as the map is worth.
        truncation: Truncation {
            keep_sway: Some(false),
            ..Truncation::default()
        },
        ..recipe(HandleCandidates::Skin, 40)
    };
    let depth = 0.028;
    let core: StiffnessRegion = toml::from_str("scale = 10.0").unwrap();
    let mapped = Recipe {
        stiffness: vec![StiffnessRegion {
            within: Some([[-1.0, -depth, -depth], [1.0, depth, depth]]),
            ..core
        }],
        ..even.clone()
    };
    let (even, mapped) = (baked(&body, &even), baked(&body, &mapped));
    assert_eq!(even.cubature.position, mapped.cubature.position);
    let whole = all_tets(&mapped).unwrap();
    let error = |fields: &[Vec<DVec3>], avatar: &Avatar| {
        let one =
            |phi: &Vec<DVec3>| energy(avatar, &mapped, phi) / energy(&whole, &whole, phi) - 1.0;
        let squares = fields.iter().map(|phi| one(phi).powi(2));
        (squares.sum::<f64>() / fields.len() as f64).sqrt()
    };
    let random = &mut Random::new(4);
    let mut wave = || {
        let (k, size) = (random.vector(60.0), random.vector(1e-3));
        let along = even.handles.iter().map(|x| size * k.dot(*x).sin());
        along.collect::<Vec<_>>()
    };
    let smooth: Vec<_> = (0..50).map(|_| wave()).collect();
    let mut noise = || (0..40).map(|_| random.vector(1e-3)).collect::<Vec<_>>();
    let rough: Vec<_> = (0..50).map(|_| noise()).collect();
    for (name, fields) in [("random", &rough), ("smooth", &smooth)] {
        let (with, without) = (error(fields, &mapped), error(fields, &even));
        println!("{name}: energy off by {with:.4} with the map, {without:.4} without");
        assert!(with < 0.6 * without, "{name}: {with} {without}");
    }
}
