//! The `supple` command as a user meets it: files, exit codes, messages.

mod bake;
mod errors;
mod lists;
#[cfg(unix)]
mod output;
mod pictures;
mod play;
mod simulate;
#[cfg(feature = "view")]
mod view;

use std::path::Path;
use std::process::{Command, Output};
use supple_files::{TetMeshFile, write_tet_mesh};
use supple_samples::Limb;

/// A scene on a limb small enough to be solved in an instant, in `folder`.
const SCENE: &str = r#"
name = "tiny"
steps = 12

[avatar]
mesh = "limb.txt"
bake.handles = [{ count = 12 }]
bake.material.stable_neo_hookean = { youngs_modulus = 30e3, poissons_ratio = 0.4 }

[[pins]]
bone = "bone"

[[colliders]]
name = "ball"
shape = { shape = "sphere", radius = 0.03 }
[colliders.motion]
x = [[0.0, 0.12]]
z = [[0.02, 0.0705], [0.08, 0.066]]

[measure]
settled = 0.02
full_press = 0.12

[output]
panel_size = [64, 48]
panels = [{ time = 0.02, caption = "rest" }, { time = 0.12, caption = "press" }]
"#;

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let limb = Limb {
        stations: 6,
        layers: 2,
        sectors: 8,
        ..Limb::S
    };
    let (mesh, pinned, surface) = limb.mesh().unwrap();
    let file = TetMeshFile {
        mesh,
        pinned,
        surface,
    };
    write_tet_mesh(&file, folder.path().join("limb.txt")).unwrap();
    std::fs::write(folder.path().join("tiny.toml"), SCENE).unwrap();
    folder
}

fn supple(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_supple"))
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

fn good(folder: &Path, arguments: &[&str]) -> String {
    let output = supple(folder, arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {stderr}");
    String::from_utf8(output.stdout).unwrap()
}

/// Exit code 1 (2 for wrong usage) and a message that holds every hint.
fn bad(folder: &Path, arguments: &[&str], code: i32, hints: &[&str]) {
    let output = supple(folder, arguments);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {stderr}");
    for hint in hints {
        assert!(
            stderr.contains(hint),
            "{arguments:?}: {hint:?} is not in: {stderr}"
        );
    }
}
