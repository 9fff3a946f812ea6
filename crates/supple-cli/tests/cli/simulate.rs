//! `supple simulate`: files of a run, reduced and in full space.

use super::{bad, folder, good};
use supple::glam::DVec3;
use supple_files::read_series;
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

/// Every step as arrays, which agree with the report on the whole run.
#[test]
fn a_series_holds_every_step() {
    let folder = folder();
    let run = [
        "simulate",
        "tiny.toml",
        "--backend",
        "cpu",
        "--no-pictures",
        "--series",
        "steps/tiny.npz",
        "--json",
    ];
    let report: Report = serde_json::from_str(&good(folder.path(), &run)).unwrap();
    let series = read_series(folder.path().join("steps/tiny.npz")).unwrap();
    let (steps, vertices) = (report.steps, report.vertices);
    assert_eq!(series.time.len(), steps);
    assert!((series.time[steps - 1] - steps as f64 * report.time_step).abs() < 1e-12);
    assert_eq!(series.vertices.len(), steps * vertices);
    let longest = |v: &[DVec3]| v.iter().map(|v| v.length()).fold(0.0, f64::max);
    let displaced = 1e3 * longest(&series.displacement);
    assert!((displaced - report.max_unposed_displacement_mm).abs() < 1e-9);
    // At rest in contact: what presses the skin is what targets and pins bear, beside the weight.
    let pressing = |step: usize| -> f64 {
        let forces = &series.contact_force[step * vertices..(step + 1) * vertices];
        forces.iter().sum::<DVec3>().length()
    };
    let nearest = (0..steps).map(|s| (pressing(s) - report.contact_force_n).abs());
    assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-6 * report.contact_force_n);
    assert!(series.loads.iter().flatten().any(|load| load.abs() > 0.1));
    assert!(
        series.energies.iter().any(|of_step| of_step[4] > 0.0),
        "contact"
    );

    let both = ["simulate", "tiny.toml", "--full-space", "--series", "a.npz"];
    bad(folder.path(), &both, 2, &["--series"]);
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
