//! What the reduced model costs in accuracy: the bone press on mesh S against its full space, over
//! handle counts, handles on the skin and in the volume, truncated and not.
//!
//! `cargo run --release --example bone_press_accuracy`

#[path = "../tests/support/press.rs"]
mod press;

use press::{press, reduced, relative_error};
use supple::bake::{HandlePlace, Truncation, all_tets, full_space};

fn main() -> supple::Result<()> {
    let start = reduced(HandlePlace::Skin, 40, Truncation::OFF);
    let truth = press(&full_space(&start)?, true);
    println!(
        "full space: {:.2} N at 12 mm, smallest det F {:.3}\n",
        truth.force, truth.min_det_f
    );
    println!(
        "| handles | where | truncated | error, cubature | error, all tets | force (N) | min det F |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (place, counts) in [
        (HandlePlace::Skin, &[40, 82, 160][..]),
        (HandlePlace::Volume, &[40, 82, 160][..]),
    ] {
        for &count in counts {
            for truncation in [Truncation::default(), Truncation::OFF] {
                let avatar = reduced(place, count, truncation);
                let cubature = press(&avatar, false);
                let tets = press(&all_tets(&avatar)?, false);
                println!(
                    "| {count} | {} | {} | {:.1} % | {:.1} % | {:.2} | {:.3} |",
                    if place == HandlePlace::Skin {
                        "skin, everywhere"
                    } else {
                        "volume, around the contact"
                    },
                    if truncation.enabled { "yes" } else { "no" },
                    100.0 * relative_error(&cubature, &truth),
                    100.0 * relative_error(&tets, &truth),
                    cubature.force,
                    cubature.min_det_f,
                );
            }
        }
    }
    Ok(())
}
