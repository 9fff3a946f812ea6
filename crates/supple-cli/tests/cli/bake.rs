//! `supple bake`, `inspect` and `sample`.

use super::{bad, folder, good};
use std::path::Path;
use supple::glam::DVec3;
use supple::internal::math::Rows;
use supple::model::SkinWeight;
use supple_bake::{Joints, ParametricModel};
use supple_files::{write_painted, write_smpl};

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
    let table = good(path, &["inspect", "a.supple"]);
    assert!(
        table.contains("limb") && table.contains("is bone"),
        "{table}"
    );
    let json = good(path, &["inspect", "a.supple", "--json"]);
    let contents: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(
        (&contents["bones"], &contents["handles"]),
        (&1.into(), &12.into())
    );
    assert_eq!(
        (&contents["up"], &contents["joints"][0]["rides"]),
        (&"z".into(), &false.into())
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
        joints: Joints::Regressor(Rows::from_iter([
            vec![(0, 1.0)],
            vec![(template.len() as u32 - 1, 1.0)],
        ])),
        parents: vec![None, Some(0)],
        names: vec!["root".into(), "tip".into()],
        shape_directions: vec![taller],
        pose_directions: Vec::new(),
        triangles,
        template,
    };
    write_smpl(&model, path).unwrap();
}

/// Standard error is no terminal here.
#[test]
fn a_bake_tells_each_phase_in_a_line() {
    let folder = tempfile::tempdir().unwrap();
    write_character(&folder.path().join("me.npz"));
    let output = crate::supple(folder.path(), &["bake", "me.npz", "--no-pictures"]);
    let told = String::from_utf8(output.stderr).unwrap();
    let lines: Vec<&str> = told
        .lines()
        .filter(|line| line.starts_with("me: "))
        .collect();
    assert_eq!(lines.len(), supple_bake::PHASES.len() + 1, "{told}");
    for (line, phase) in lines.iter().zip(supple_bake::PHASES) {
        assert!(line.contains(phase), "{line}");
    }
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
    for picture in ["tissue", "handles", "basis", "cubature", "skin_weights"] {
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

/// The images of a character's file are in what is simulated of its bake, and that file is not asked for again.
#[test]
fn textures_come_through_a_bake_and_a_simulation() {
    let original = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/assets/khronos-CesiumMan.glb"
    );
    if !Path::new(original).exists() {
        println!("skipped: {original} is not there");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    std::fs::copy(original, path.join("man.glb")).unwrap();
    good(path, &["bake", "man.glb", "--no-pictures"]);
    std::fs::remove_file(path.join("man.glb")).unwrap();
    let scene =
        "name = \"still\"\nsteps = 2\n[avatar]\nfile = \"out/man.supple\"\n[output]\npanels = []\n";
    std::fs::write(path.join("still.toml"), scene).unwrap();
    good(
        path,
        &["simulate", "still.toml", "--backend", "cpu", "-o", "here"],
    );
    let pictures = |file: &Path| -> Vec<Vec<u8>> {
        let gltf::Gltf { document, blob } = gltf::Gltf::open(file).unwrap();
        let blob = blob.unwrap();
        let bytes = |image: gltf::Image<'_>| match image.source() {
            gltf::image::Source::View { view, .. } => {
                blob[view.offset()..view.offset() + view.length()].to_vec()
            }
            gltf::image::Source::Uri { .. } => panic!("an image outside"),
        };
        document.images().map(bytes).collect()
    };
    let written = path.join("here/avatar.glb");
    assert_eq!(pictures(&written), pictures(Path::new(original)));
    let gltf::Gltf { document, .. } = gltf::Gltf::open(&written).unwrap();
    let skin = document
        .meshes()
        .next()
        .unwrap()
        .primitives()
        .next()
        .unwrap();
    let material = skin.material().pbr_metallic_roughness();
    assert!(material.base_color_texture().is_some());
    assert!(skin.get(&gltf::Semantic::TexCoords(0)).is_some());
}
