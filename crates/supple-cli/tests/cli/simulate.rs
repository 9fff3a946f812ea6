//! `supple simulate`: files of a run, reduced and in full space.

use super::{bad, folder, good};
use supple_scene::Report;

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
    assert!(report.det_f() > 0.0 && report.det_f() < 1.0, "{report:?}");
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
fn a_scene_of_the_program_is_found_by_its_name_in_any_folder() {
    let folder = tempfile::tempdir().unwrap();
    let run = [
        "simulate",
        "finger_press",
        "--backend",
        "cpu",
        "--no-pictures",
        "--json",
    ];
    let report: Report = serde_json::from_str(&good(folder.path(), &run)).unwrap();
    assert_eq!(report.scene, "finger_press");
    let unknown = ["simulate", "finger_pres"];
    bad(
        folder.path(),
        &unknown,
        1,
        &["finger_pres:", "finger_press"],
    );
}
