//! The reduced model against the full space: the bone press on mesh S in equilibrium, 12 mm deep. The
//! whole table is printed by `cargo run --release --example bone_press_accuracy`.

#[path = "support/press.rs"]
mod press;

use press::{press, reduced, relative_error};
use supple::bake::{HandlePlace, Truncation, all_tets, full_space};

#[test]
fn error_falls_with_handles_and_truncation_leaves_a_floor() {
    let avatar =
        |count, truncation| all_tets(&reduced(HandlePlace::Volume, count, truncation)).unwrap();
    let coarse = avatar(20, Truncation::OFF);
    let truth = press(&full_space(&coarse).unwrap(), true);
    // The published force of the converged full-space solution on this mesh.
    assert!((truth.force / 15.9 - 1.0).abs() < 0.05, "{} N", truth.force);
    let errors = [
        coarse,
        avatar(40, Truncation::OFF),
        avatar(80, Truncation::OFF),
    ]
    .map(|avatar| relative_error(&press(&avatar, false), &truth));
    let truncated = relative_error(&press(&avatar(80, Truncation::default()), false), &truth);
    println!("20, 40, 80 handles: {errors:.3?}; 80 truncated: {truncated:.3}");
    assert!(
        errors[0] > errors[1] && errors[1] > errors[2] && errors[2] < 0.45,
        "{errors:?}"
    );
    assert!(truncated > errors[2] && truncated < 0.5, "{truncated}");
}

/// Ten points a handle, whatever the handles; the whole table is the example's.
#[test]
fn cubature_adds_at_most_a_fifth_to_the_error_of_all_tets() {
    let full = reduced(HandlePlace::Skin, 30, Truncation::default());
    let truth = press(&full_space(&full).unwrap(), true);
    for (place, count) in [
        (HandlePlace::Skin, 40),
        (HandlePlace::Skin, 82),
        (HandlePlace::Volume, 30),
        (HandlePlace::Volume, 82),
        (HandlePlace::Volume, 120),
    ] {
        let avatar = reduced(place, count, Truncation::default());
        assert_eq!(avatar.cubature.len(), 10 * count);
        let cubature = relative_error(&press(&avatar, false), &truth);
        let whole = relative_error(&press(&all_tets(&avatar).unwrap(), false), &truth);
        let share = cubature / whole - 1.0;
        println!(
            "{place:?} {count}: {cubature:.3} with cubature, {whole:.3} with all tets, share {share:.3}"
        );
        assert!(share < 0.2, "{place:?} {count}: {cubature} against {whole}");
    }
}
