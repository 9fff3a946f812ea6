//! The reduced model against the full space: the bone press on mesh S in equilibrium, 12 mm deep. The
//! whole study is the figure `bone_press`.

use std::sync::Arc;
use supple::model::Avatar;
use supple_bake::{HandleCandidates, HandleRegion, Recipe, Truncation, all_tets, bake};
use supple_lab::press::{Pressed, limb_recipe, press, press_full_space};
use supple_samples::Limb;

/// m.
const DEPTHS: [f64; 4] = [0.0, 0.004, 0.008, 0.012];

/// The limb with `count` handles, on all of its skin or in the volume around the contact.
fn reduced(candidates: HandleCandidates, count: usize, truncation: Truncation) -> Avatar {
    let around_contact = [[0.04, -0.045, -0.005], [0.16, 0.045, 0.045]];
    let recipe = Recipe {
        handles: vec![HandleRegion {
            candidates,
            count: Some(count),
            within: (candidates == HandleCandidates::Volume).then_some(around_contact),
            ..HandleRegion::default()
        }],
        truncation,
        ..limb_recipe()
    };
    let body = Limb::S.body().unwrap();
    bake(&body, &recipe, &mut |_| {}).unwrap().0
}

fn error(avatar: Avatar, truth: &Pressed) -> f64 {
    press(&Arc::new(avatar), &DEPTHS)
        .unwrap()
        .relative_error(truth)
}

#[test]
fn error_falls_with_handles_and_truncation_leaves_a_floor() {
    let avatar = |count, truncation| {
        all_tets(&reduced(HandleCandidates::Volume, count, truncation)).unwrap()
    };
    let coarse = avatar(20, Truncation::OFF);
    let truth = press_full_space(&coarse, &DEPTHS).unwrap();
    // The published force of the converged full-space solution on this mesh.
    let force = truth.force();
    assert!((force / 15.9 - 1.0).abs() < 0.05, "{force} N");
    let errors = [
        coarse,
        avatar(40, Truncation::OFF),
        avatar(80, Truncation::OFF),
    ]
    .map(|avatar| error(avatar, &truth));
    let truncated = error(avatar(80, Truncation::default()), &truth);
    println!("20, 40, 80 handles: {errors:.3?}; 80 truncated: {truncated:.3}");
    assert!(
        errors[0] > errors[1] && errors[1] > errors[2] && errors[2] < 0.45,
        "{errors:?}"
    );
    assert!(truncated > errors[2] && truncated < 0.5, "{truncated}");
}

/// Ten points a handle, whatever the handles; the whole table is the figure `cubature`.
#[test]
fn cubature_adds_at_most_a_fifth_to_the_error_of_all_tets() {
    let full = reduced(HandleCandidates::Skin, 30, Truncation::default());
    let truth = press_full_space(&full, &DEPTHS).unwrap();
    for (candidates, count) in [
        (HandleCandidates::Skin, 40),
        (HandleCandidates::Skin, 82),
        (HandleCandidates::Volume, 30),
        (HandleCandidates::Volume, 82),
        (HandleCandidates::Volume, 120),
    ] {
        let avatar = reduced(candidates, count, Truncation::default());
        assert_eq!(avatar.cubature.len(), 10 * count);
        let whole = error(all_tets(&avatar).unwrap(), &truth);
        let cubature = error(avatar, &truth);
        let share = cubature / whole - 1.0;
        println!(
            "{candidates:?} {count}: {cubature:.3} with cubature, {whole:.3} with all tets, share {share:.3}"
        );
        assert!(
            share < 0.2,
            "{candidates:?} {count}: {cubature} against {whole}"
        );
    }
}
