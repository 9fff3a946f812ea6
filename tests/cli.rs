//! The `supple` command as a user meets it: files, exit codes, messages.
#![cfg(feature = "cli")]

use std::path::Path;
use std::process::{Command, Output};
use supple::export::{Report, write_tet_mesh};
use supple::load::TetMeshFile;
use supple::sample::Limb;

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

#[test]
fn a_scene_becomes_pictures_a_glb_and_a_report() {
    let folder = folder();
    let run = [
        "simulate",
        "tiny.toml",
        "--backend",
        "cpu",
        "--json",
        "-o",
        "results",
    ];
    let report: Report = serde_json::from_str(&good(folder.path(), &run)).unwrap();
    assert_eq!(
        (report.backend.as_str(), report.steps, report.handles),
        ("cpu", 12, 12)
    );
    assert_eq!(report.dofs, 6 + 3 * 12);
    assert!(report.contact_force_n > 0.1, "{report:?}");
    assert!(report.max_unposed_displacement_mm > 0.5, "{report:?}");
    assert!(
        report.min_det_f > 0.0 && report.min_det_f < 1.0,
        "{report:?}"
    );
    assert!(report.max_penetration_mm < 1.0, "{report:?}");
    let results = folder.path().join("results");
    let file = |name: &str| std::fs::read(results.join(name)).unwrap();
    let written: Report = serde_json::from_slice(&file("report.json")).unwrap();
    assert_eq!(written, report);
    assert!(file("avatar.glb").starts_with(b"glTF"));
    assert!(file("strip.png").starts_with(b"\x89PNG"));

    let cache = || {
        std::fs::read_dir(folder.path().join("out/cache"))
            .unwrap()
            .count()
    };
    assert_eq!(cache(), 1, "the bake is kept");
    let (strip, glb) = (file("strip.png"), file("avatar.glb"));
    let again: Report = serde_json::from_str(&good(folder.path(), &run)).unwrap();
    assert_eq!(cache(), 1, "and found again");
    let untimed = |r: &Report| Report {
        ms_per_step: Default::default(),
        ms_per_step_in_contact: Default::default(),
        breakdown_ms: Default::default(),
        ..r.clone()
    };
    assert_eq!(untimed(&again), untimed(&report), "the same bits");
    assert_eq!((file("strip.png"), file("avatar.glb")), (strip, glb));
}

#[test]
fn the_full_space_runs_on_the_cpu() {
    let folder = folder();
    let run = [
        "simulate",
        "tiny.toml",
        "--full-space",
        "--no-pictures",
        "--json",
    ];
    let report: Report = serde_json::from_str(&good(folder.path(), &run)).unwrap();
    assert_eq!(report.backend, "cpu, full space");
    assert!(report.handles > 50, "{report:?}");
    assert!(!folder.path().join("out/tiny/strip.png").exists());
    let gpu = ["simulate", "tiny.toml", "--full-space", "--backend", "gpu"];
    bad(
        folder.path(),
        &gpu,
        1,
        &["--full-space", "leave --backend gpu out"],
    );
}

#[test]
fn bakes_are_the_same_and_can_be_inspected() {
    let folder = folder();
    let path = folder.path();
    good(
        path,
        &["bake", "tiny.toml", "-o", "a.supple", "--no-pictures"],
    );
    let json = good(path, &["bake", "tiny.toml", "-o", "b.supple", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(report["handles"]["count"], 12);
    let read = |name: &str| std::fs::read(path.join(name)).unwrap();
    assert_eq!(read("a.supple"), read("b.supple"));
    assert!(good(path, &["inspect", "a.supple"]).contains("limb"));
    let json = good(path, &["inspect", "a.supple", "--json"]);
    let contents: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        (&contents["bones"], &contents["handles"]),
        (&1.into(), &12.into())
    );
}

#[test]
fn samples_are_complete() {
    let folder = folder();
    good(folder.path(), &["sample", "limb", "-o", "models"]);
    good(
        folder.path(),
        &["bake", "models/limb.toml", "-o", "limb.supple"],
    );
}

#[test]
fn adapters_are_listed() {
    let folder = tempfile::tempdir().unwrap();
    let json = good(folder.path(), &["adapters", "--json"]);
    assert!(
        serde_json::from_str::<serde_json::Value>(&json)
            .unwrap()
            .is_array()
    );
    assert!(!good(folder.path(), &["adapters"]).is_empty());
}

#[test]
fn what_is_wrong_is_said() {
    let folder = folder();
    let path = folder.path();
    let changed = |name: &str, from: &str, to: &str| {
        assert!(SCENE.contains(from));
        std::fs::write(path.join(name), SCENE.replacen(from, to, 1)).unwrap();
    };
    changed("key.toml", "steps = 12", "steps = 12\nstpes = 1");
    bad(
        path,
        &["simulate", "key.toml"],
        1,
        &["key.toml", "line 4", "stpes"],
    );
    changed("nan.toml", "[0.02, 0.0705]", "[0.02, nan]");
    bad(
        path,
        &["simulate", "nan.toml"],
        1,
        &["nan.toml", "colliders[0].motion.z[0][1]", "finite"],
    );
    changed("mesh.toml", "limb.txt", "nowhere.txt");
    bad(path, &["simulate", "mesh.toml"], 1, &["nowhere.txt"]);
    changed("bone.toml", "bone = \"bone\"", "bone = \"elbow\"");
    let cpu = ["simulate", "bone.toml", "--backend", "cpu"];
    bad(path, &cpu, 1, &["pins[0].bone", "elbow", "there are bone"]);
    bad(path, &["simulate", "nowhere.toml"], 1, &["nowhere.toml"]);
    bad(
        path,
        &["inspect", "tiny.toml"],
        1,
        &["tiny.toml", "not a baked avatar"],
    );
    changed(
        "foreign.toml",
        "mesh = \"limb.txt\"\nbake.handles = [{ count = 12 }]\nbake.material.stable_neo_hookean = { youngs_modulus = 30e3, poissons_ratio = 0.4 }",
        "file = \"limb.txt\"",
    );
    bad(
        path,
        &["simulate", "foreign.toml"],
        1,
        &["limb.txt", "not a baked avatar"],
    );
    std::fs::write(path.join("cut.txt"), "8 5 1").unwrap();
    bad(path, &["bake", "cut.txt"], 1, &["cut.txt", "line 1"]);
    std::fs::write(path.join("mesh.fbx"), "Kaydara").unwrap();
    bad(
        path,
        &["bake", "mesh.fbx"],
        1,
        &["mesh.fbx", ".glb", ".npz"],
    );
    bad(
        path,
        &["simulate", "tiny.toml", "--backend", "abacus"],
        2,
        &["abacus", "cpu"],
    );
    bad(path, &["frobnicate"], 2, &["frobnicate"]);
}
