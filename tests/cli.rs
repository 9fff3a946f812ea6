//! The `supple` command as a user meets it: files, exit codes, messages.
#![cfg(feature = "cli")]

use std::path::Path;
use std::process::{Command, Output};
use supple::export::{Report, write_painted, write_smpl, write_tet_mesh};
use supple::glam::DVec3;
use supple::load::TetMeshFile;
use supple::math::Rows;
use supple::model::{ParametricModel, SkinWeight};
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

/// A character of two bones in SMPL's layout: a box of 2 × 2 × 6 cells.
fn write_character(path: &Path) {
    let [nx, ny, nz] = [2u32, 2, 6];
    let grid = |i: u32, j: u32, k: u32| DVec3::new(f64::from(i), f64::from(j), f64::from(k)) * 0.04;
    let mut index = std::collections::HashMap::new();
    let mut template = Vec::new();
    let mut triangles = Vec::new();
    let mut vertex = |p: [u32; 3]| {
        *index.entry(p).or_insert_with(|| {
            template.push(grid(p[0], p[1], p[2]));
            template.len() as u32 - 1
        })
    };
    let size = [nx, ny, nz];
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for (a, b) in (0..size[u]).flat_map(|a| (0..size[v]).map(move |b| (a, b))) {
            for side in [0, size[axis]] {
                let mut corner = |da: u32, db: u32| {
                    let mut p = [0; 3];
                    (p[axis], p[u], p[v]) = (side, a + da, b + db);
                    vertex(p)
                };
                let q = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                let outward = [[q[0], q[1], q[2]], [q[0], q[2], q[3]]];
                let flip = |[a, b, c]: [u32; 3]| if side == 0 { [a, c, b] } else { [a, b, c] };
                triangles.extend(outward.map(flip));
            }
        }
    }
    let taller: Vec<DVec3> = template
        .iter()
        .map(|p: &DVec3| DVec3::Z * p.z * 0.1)
        .collect();
    let weight = |p: &DVec3| {
        let bone = u32::from(p.z > 0.12);
        [SkinWeight { bone, weight: 1.0 }]
    };
    let model = ParametricModel {
        weights: template.iter().map(weight).collect(),
        joint_regressor: Rows::from_iter([vec![(0, 1.0)], vec![(template.len() as u32 - 1, 1.0)]]),
        parents: vec![None, Some(0)],
        names: vec!["root".into(), "tip".into()],
        shape_directions: vec![taller],
        pose_directions: Vec::new(),
        triangles,
        template,
    };
    write_smpl(&model, path).unwrap();
}

#[test]
fn a_character_file_bakes_with_no_recipe_and_with_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_character(&path.join("me.npz"));
    let told = good(path, &["inspect", "me.npz"]);
    assert!(
        told.contains("root, tip") && told.contains("supple bake me.npz"),
        "{told}"
    );
    let json = good(path, &["bake", "me.npz", "--json"]);
    let plain: serde_json::Value = serde_json::from_str(&json).unwrap();
    for picture in ["handles", "basis", "cubature", "skin_weights"] {
        let bytes = std::fs::read(path.join(format!("out/me.bake/{picture}.png"))).unwrap();
        assert!(bytes.starts_with(b"\x89PNG"), "{picture}");
    }
    let told = good(path, &["inspect", "out/me.supple"]);
    for hint in ["(chosen)", "mass of", "cubature", "degrees of freedom"] {
        assert!(told.contains(hint), "{hint}: {told}");
    }
    // A taller person is heavier; another recipe gives what it says.
    let tall = [
        "bake",
        "me.npz",
        "--shape",
        "2",
        "--json",
        "--no-pictures",
        "-o",
        "tall.supple",
    ];
    let tall: serde_json::Value = serde_json::from_str(&good(path, &tall)).unwrap();
    let mass = |r: &serde_json::Value| {
        r["tissue_mass"].as_f64().unwrap() + r["bones"]["total"].as_f64().unwrap()
    };
    assert!(
        (mass(&tall) / mass(&plain) - 1.2).abs() < 0.05,
        "{} {}",
        mass(&tall),
        mass(&plain)
    );
    assert!(tall["extent"][2].as_f64().unwrap() > 1.19 * plain["extent"][2].as_f64().unwrap());
    std::fs::write(
        path.join("mine.toml"),
        "[bake]\ndensity = 900.0\n[[bake.handles]]\nbones = [\"tip\"]\ncount = 5\n",
    )
    .unwrap();
    let mine = [
        "bake",
        "me.npz",
        "--recipe",
        "mine.toml",
        "--json",
        "--no-pictures",
    ];
    let mine: serde_json::Value = serde_json::from_str(&good(path, &mine)).unwrap();
    assert_eq!(mine["handles"]["per_bone"], serde_json::json!([0, 5]));
    // What is wrong is said with file, key and cure.
    let recipe = |text: &str| std::fs::write(path.join("mine.toml"), text).unwrap();
    let run = ["bake", "me.npz", "--recipe", "mine.toml"];
    recipe("[[bake.handles]]\nbones = [\"elbow\"]");
    bad(
        path,
        &run,
        1,
        &[
            "mine.toml",
            "bake.handles[0].bones",
            "elbow",
            "there are root, tip",
        ],
    );
    recipe("[bake]\ndensity = -1.0");
    bad(path, &run, 1, &["mine.toml", "bake.density", "positive"]);
    recipe("[bake]\nmesher.prism_shell.thickness = -0.01");
    bad(
        path,
        &run,
        1,
        &["mine.toml", "bake.mesher.thickness", "positive (m)"],
    );
    recipe("[painted]\nbelly = \"belly.npy\"\n[[bake.handles]]\npainted = \"belly\"");
    bad(path, &run, 1, &["belly.npy"]);
    write_painted(&[1.0; 3], path.join("belly.npy")).unwrap();
    bad(
        path,
        &run,
        1,
        &["belly.npy", "painted.belly", "3 numbers", "vertices"],
    );
    let shapes = ["bake", "me.npz", "--shape", "1,2,3"];
    bad(path, &shapes, 1, &["me.npz", "shape", "the model has 1"]);
    std::fs::write(path.join("cut.npz"), "PK\x03\x04").unwrap();
    bad(path, &["bake", "cut.npz"], 1, &["cut.npz"]);
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
fn figures_are_listed_and_found_by_name() {
    let folder = folder();
    let listed = good(folder.path(), &["figures", "--list"]);
    for figure in supple::figures::FIGURES {
        assert!(listed.contains(figure.name) && listed.contains(figure.title));
    }
    let unknown = ["figures", "--only", "rigid_sof"];
    bad(
        folder.path(),
        &unknown,
        1,
        &["--only", "rigid_sof", "rigid_soft"],
    );
    // Where there are no scenes, the figure says so, and the page with it.
    let lost = ["figures", "--only", "rigid_soft", "--small"];
    bad(folder.path(), &lost, 1, &["1 of 1 checks fail"]);
    let page = std::fs::read_to_string(folder.path().join("out/figures/index.html")).unwrap();
    assert!(page.contains("finger_press.toml"), "{page}");
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
