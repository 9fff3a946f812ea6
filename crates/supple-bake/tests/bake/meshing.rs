//! Soft layers for any skin: no inverted tet, whatever the skin is like.

use std::path::{Path, PathBuf};
use supple::glam::DVec3;
use supple::internal::math::Random;
use supple::model::{Avatar, SkinWeight};
use supple_bake::mesh::{LatticeSize, MeshReport, ShellOptions};
use supple_bake::{Body, CubatureRecipe, HandleRegion, Mesher, Recipe, bake};
use supple_files::read_character;
use supple_samples::{Finger, hand};

/// What holds for every layer.
fn check(body: &Body, report: &MeshReport) {
    let vertices = body.skin.positions.len();
    body.layer.validate(vertices, body.skeleton.len()).unwrap();
    assert_eq!(report.quality.inverted, 0);
    let [least, median, most] = report.thickness;
    assert!(0.0 < least && least <= median && median <= most);
    assert!(report.tissue_volume > 0.0);
    let mut used = vec![false; body.layer.mesh.nodes.len()];
    (body.layer.mesh.tets.iter().flatten()).for_each(|&n| used[n as usize] = true);
    assert!(used.iter().all(|used| *used), "a node belongs to no tet");
    assert!(body.layer.bone_of_node.iter().any(Option::is_some));
    assert!(body.layer.bone_of_node.iter().any(Option::is_none));
}

fn meshed(body: &Body, mesher: &Mesher) -> (Body, MeshReport) {
    let mut body = body.clone();
    let report = mesher.mesh(&mut body).unwrap();
    check(&body, &report);
    (body, report)
}

fn shell() -> Mesher {
    Mesher::PrismShell(ShellOptions::default())
}

/// The sample finger with `count` random bumps and dents, each up to `size` of its extent.
fn bumpy(seed: u64, count: usize, size: f64) -> Body {
    let mut body = Finger::default().body().unwrap();
    body.layer = Default::default();
    let mut random = Random::new(seed);
    for _ in 0..count {
        let centre = body.skin.positions[random.index(body.skin.positions.len())];
        let width = random.uniform(0.002, 0.015);
        let push = random.vector(0.088 * size);
        for p in &mut body.skin.positions {
            *p += push * (-(*p - centre).length_squared() / (width * width)).exp();
        }
    }
    body
}

fn scaled(body: &Body, scale: f64) -> Body {
    let mut body = body.clone();
    body.skin.positions.iter_mut().for_each(|p| *p *= scale);
    body.skeleton.joints.iter_mut().for_each(|p| *p *= scale);
    body
}

#[test]
fn bumpy_skins_never_give_inverted_tets() {
    for seed in 0..12 {
        let body = bumpy(seed, 4 + 4 * seed as usize, 0.02 + 0.01 * seed as f64);
        let (_, report) = meshed(&body, &shell());
        println!("seed {seed}: {}; {}", report.skin, report.quality);
    }
}

#[test]
fn a_body_of_any_size_is_meshed_alike() {
    let body = bumpy(5, 10, 0.03);
    let (_, report) = meshed(&body, &shell());
    for scale in [0.01f64, 100.0] {
        let (_, other) = meshed(&scaled(&body, scale), &shell());
        let ratio = other.tissue_volume / (report.tissue_volume * scale.powi(3));
        assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
        assert_eq!(other.quality.tets, report.quality.tets);
        assert_eq!(other.bare_vertices, report.bare_vertices);
    }
}

#[test]
fn holes_are_closed_reported_and_held() {
    for seed in 0..6 {
        let mut body = bumpy(seed, 6, 0.02);
        let mut random = Random::new(seed + 100);
        // Triangles around a few random places are cut out.
        for _ in 0..3 {
            let centre = body.skin.positions[random.index(body.skin.positions.len())];
            let radius = random.uniform(0.002, 0.007);
            let positions = body.skin.positions.clone();
            (body.skin.triangles).retain(|t| {
                t.iter()
                    .all(|&v| positions[v as usize].distance(centre) > radius)
            });
        }
        for mesher in [shell(), Mesher::Lattice(LatticeSize::Cell(0.003))] {
            let (meshed, report) = meshed(&body, &mesher);
            assert!(!report.skin.holes.is_empty() && report.skin.isolated_vertices > 0);
            assert!(report.skin_volume > 0.5 * 15e-6, "{}", report.skin_volume);
            // What is cut off follows its bones.
            let bare = meshed
                .layer
                .skin_embedding
                .iter()
                .filter(|row| row.is_empty());
            assert!(bare.count() >= report.skin.isolated_vertices);
        }
    }
}

/// MANO's hand is open at the wrist: so is the sample hand without the triangles behind it.
#[test]
fn a_hand_open_at_the_wrist() {
    let hand = hand().unwrap();
    let whole = Body::of_model("hand", &hand.model, &[], hand.bones);
    let wrist = whole
        .skin
        .positions
        .iter()
        .map(|p| p.x)
        .fold(f64::INFINITY, f64::min);
    let mut body = whole.clone();
    body.skin.triangles.retain(|t| {
        let places = t.map(|v| whole.skin.positions[v as usize].x);
        places.iter().any(|x| *x > wrist + 0.002)
    });
    assert!(body.skin.triangles.len() < whole.skin.triangles.len());
    let size = LatticeSize::Nodes(6000);
    let (closed, with) = meshed(&whole, &Mesher::Lattice(size));
    let (open, without) = meshed(&body, &Mesher::Lattice(size));
    assert_eq!(without.skin.holes.len(), 1, "{}", without.skin);
    assert!((without.skin_volume / with.skin_volume - 1.0).abs() < 0.02);
    assert!((without.tissue_volume / with.tissue_volume - 1.0).abs() < 0.03);
    let held = |body: &Body| body.layer.bone_of_node.iter().flatten().count();
    assert!(held(&open) > held(&closed));
}

/// Without bone surfaces the hand gets bones from its joints and weights, inside the skin and apart.
#[test]
fn bones_from_joints_and_weights() {
    let hand = hand().unwrap();
    let bare = Body::of_model("hand", &hand.model, &[], Vec::new());
    let (body, report) = meshed(&bare, &Mesher::Auto);
    assert!(report.mesher.starts_with("lattice"), "{}", report.mesher);
    assert_eq!(report.derived_bones, body.skeleton.len());
    assert_eq!(report.bare_vertices, 0);
    for bone in 0..body.skeleton.len() as u32 {
        assert!(body.layer.bone_of_node.contains(&Some(bone)), "bone {bone}");
    }
    let core = report.core_volume / report.skin_volume;
    assert!((0.05..0.5).contains(&core), "{core}");
}

/// Both meshers on one finger, the lattice around the shell's own core: volume, centre of mass and what each bone
/// carries of it agree within mesh noise. The handles' columns do not: a lattice holds a staircase of nodes
/// where a shell ends at the bone, which clamps U's slope there.
#[test]
fn lattice_and_shell_agree() {
    let mut body = Finger::default().body().unwrap();
    body.layer = Default::default();
    let options = ShellOptions {
        thickness: Some(0.003),
        ..ShellOptions::default()
    };
    let (shelled, shell) = meshed(&body, &Mesher::PrismShell(options));
    // The inner surface of the shell, as the surface of one bone.
    let layer = &shelled.layer;
    let inner = |t: &[u32; 3]| t.iter().all(|&n| layer.bone_of_node[n as usize].is_some());
    let mut core = supple::model::Surface {
        positions: layer.mesh.nodes.clone(),
        triangles: layer.mesh.boundary_triangles(),
    };
    core.triangles.retain(inner);
    core.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    body.bone_surfaces = vec![Default::default(); 3];
    body.bone_surfaces[0] = core;
    let (latticed, lattice) = meshed(&body, &Mesher::Lattice(LatticeSize::Cell(0.0012)));
    let ratio = lattice.tissue_volume / shell.tissue_volume;
    println!("tissue of lattice over shell: {ratio}");
    assert!((ratio - 1.0).abs() < 0.005, "{ratio}");
    let centre = |body: &Body| {
        let layer = &body.layer;
        let shares = (layer.tissue_fraction.iter().enumerate())
            .map(|(t, f)| f * layer.mesh.volume(t) * layer.mesh.centroid(t));
        shares.sum::<DVec3>() / layer.tissue_volume()
    };
    let apart = centre(&latticed).distance(centre(&shelled));
    assert!(apart < 0.0005, "{apart}");

    // The core is one surface: each node it holds goes to the bone that holds the shell there.
    let held = |n: &usize| shelled.layer.bone_of_node[*n].is_some();
    let held: Vec<usize> = (0..shelled.layer.mesh.nodes.len()).filter(held).collect();
    let mut latticed = latticed;
    let layer = &mut latticed.layer;
    for (bone, place) in layer.bone_of_node.iter_mut().zip(&layer.mesh.nodes) {
        let distance = |n: &&usize| shelled.layer.mesh.nodes[**n].distance_squared(*place);
        let nearest = |held: &[usize]| {
            *held
                .iter()
                .min_by(|a, b| distance(a).total_cmp(&distance(b)))
                .unwrap()
        };
        *bone = bone.and_then(|_| shelled.layer.bone_of_node[nearest(&held)]);
    }
    let recipe = Recipe {
        handles: vec![HandleRegion {
            vertices: (0..body.skin.positions.len() as u32).step_by(23).collect(),
            ..HandleRegion::default()
        }],
        cubature: CubatureRecipe {
            all_tets: true,
            ..CubatureRecipe::default()
        },
        ..Recipe::default()
    };
    let [shelled, latticed] =
        [&shelled, &latticed].map(|body| bake(body, &recipe, &mut |_| {}).unwrap().0);
    // ∫ U over the tissue, all handles together.
    let reached = |avatar: &Avatar| -> f64 {
        let points = avatar.cubature.basis.iter().zip(&avatar.cubature.measure);
        points
            .map(|(row, w)| w * row.iter().map(|u| u.value).sum::<f64>())
            .sum()
    };
    let ratio = reached(&latticed) / reached(&shelled);
    println!("∫ U of lattice over shell: {ratio:.3}");
    let volume: f64 = shelled.cubature.measure.iter().sum();
    for bone in 0..3 {
        let share = |avatar: &Avatar| -> f64 {
            let points = avatar
                .cubature
                .skinning
                .iter()
                .zip(&avatar.cubature.measure);
            let weight = |row: &[SkinWeight]| {
                let own = row.iter().filter(|w| w.bone == bone);
                own.map(|w| w.weight).sum::<f64>()
            };
            points.map(|(row, w)| w * weight(row)).sum::<f64>() / volume
        };
        let (a, b) = (share(&shelled), share(&latticed));
        println!("bone {bone} carries {a:.4} of the shell, {b:.4} of the lattice");
        assert!((a - b).abs() < 0.005, "bone {bone}: {a} and {b}");
    }
}

#[test]
fn painted_and_single_bones_thickness() {
    let mut body = Finger::default().body().unwrap();
    body.layer = Default::default();
    let bare = Mesher::PrismShell(ShellOptions {
        thickness_of_bone: [("distal".to_string(), 0.001)].into(),
        ..ShellOptions::default()
    });
    let whole = meshed(&body, &shell()).1;
    let thin = meshed(&body, &bare).1;
    assert!(thin.thickness[0] < 0.7 * whole.thickness[0]);
    assert!(thin.tissue_volume < whole.tissue_volume);
    let along = |p: &DVec3| (p.x / 0.09).clamp(0.1, 1.0);
    let map: Vec<f64> = body.skin.positions.iter().map(along).collect();
    body.painted.insert("soft".into(), map);
    let painted = |name: &str| {
        Mesher::PrismShell(ShellOptions {
            thickness: Some(0.003),
            painted_thickness: Some(name.into()),
            ..ShellOptions::default()
        })
    };
    let report = meshed(&body, &painted("soft")).1;
    assert!(report.thickness[0] < 0.001 && report.thickness[2] > 0.002);
    for (wrong, named) in [
        (painted("hard"), "painted_thickness"),
        (
            Mesher::PrismShell(ShellOptions {
                thickness_of_bone: [("tail".to_string(), 0.001)].into(),
                ..ShellOptions::default()
            }),
            "tail",
        ),
        (
            Mesher::PrismShell(ShellOptions {
                thickness: Some(-1.0),
                ..ShellOptions::default()
            }),
            "thickness",
        ),
    ] {
        let message = wrong.mesh(&mut body.clone()).unwrap_err().to_string();
        assert!(message.contains(named), "{message}");
    }
}

#[test]
fn the_same_mesh_twice() {
    let body = bumpy(3, 10, 0.03);
    for mesher in [shell(), Mesher::Lattice(LatticeSize::Cell(0.003))] {
        let [a, b] = [0, 1].map(|_| meshed(&body, &mesher));
        assert!(a.0.layer == b.0.layer && a.1 == b.1);
    }
}

#[test]
fn real_files() {
    let folder: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/assets");
    for (file, mesher) in [
        ("khronos-CesiumMan.glb", "prism shell"),
        ("khronos-RiggedSimple.glb", "prism shell"),
        ("makehuman-female-cmu-02_01.glb", "prism shell"),
        (
            "makehuman-female-game_engine-smpl-layout.npz",
            "prism shell",
        ),
        ("webxr-generic-hand-left.glb", "lattice"),
    ] {
        let path = folder.join(file);
        if !path.exists() {
            println!("skipped: {} is not there", path.display());
            continue;
        }
        let (body, report) = meshed(
            &read_character(&path, &Default::default()).unwrap().body,
            &Mesher::Auto,
        );
        println!(
            "{}: {}; {}; {}",
            body.name, report.mesher, report.skin, report.quality
        );
        assert!(report.mesher.starts_with(mesher), "{}", report.mesher);
        // The toy's large triangles lie over a head of 9 mm in three layers.
        let least = if file.contains("CesiumMan") {
            12.0
        } else {
            20.0
        };
        assert!(report.quality.median_dihedral > least, "{}", report.quality);
        assert!(50 * report.bare_vertices < report.skin.vertices);
    }
}
