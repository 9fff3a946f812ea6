//! Every figure at its small size, and every committed scene on the GPU as on the CPU.

mod command;
mod figures;
mod hand_press;
mod lock;
mod reduced_accuracy;
mod scene_parity;

use std::path::Path;
use std::sync::LazyLock;
use supple_lab::{Runner, Size};

/// One for all: what a test bakes, the others have.
static RUNNER: LazyLock<Runner> = LazyLock::new(|| {
    let cache = Path::new(env!("CARGO_TARGET_TMPDIR")).join("lab");
    Runner::new(Size::Small, SCENES, cache, |_| {})
});

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../assets/scenes");
