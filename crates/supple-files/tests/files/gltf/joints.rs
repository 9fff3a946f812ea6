//! A host's own world matrices of a file's nodes, and whether the skin follows them as the file's own skinning does.

use super::evaluation::{Evaluation, largest_distance, local_rest, posed};
use super::fixture::{BONES, BarFile, bar_file};
use glam::{DMat4, DQuat, DVec3, Mat4};
use serde_json::json;
use std::path::PathBuf;
use supple::internal::math::Random;
use supple::model::{JointBone, UpAxis};
use supple_bake::Body;
use supple_files::{parse_gltf, read_character};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/assets");

/// The real file of this name; says so where it is not there.
fn asset(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(FOLDER).join(name);
    if !path.exists() {
        println!("skipped: {} is not there", path.display());
        return None;
    }
    Some(path)
}

fn body_of(bytes: &[u8]) -> Body {
    parse_gltf(bytes, "file.glb").unwrap().body(&[]).unwrap()
}

/// The node of each joint.
fn nodes(file: &Evaluation, body: &Body) -> Vec<usize> {
    let node = |name: &str| file.document.nodes().find(|n| n.name() == Some(name));
    let joints = body.joints.joints().iter();
    joints.map(|j| node(&j.name).unwrap().index()).collect()
}

/// How far vertices of the file are, driven by its nodes' `world` matrices in f32, from its own skinning, m; by the world
/// matrices and by the first skin's skinning matrices.
fn distances(file: &Evaluation, body: &Body, world: &[DMat4]) -> [f64; 2] {
    let nodes = nodes(file, body);
    let given: Vec<Mat4> = nodes.iter().map(|&n| world[n].as_mat4()).collect();
    let (list, mut frames) = (&body.joints, Vec::new());
    list.frames_from_world(&body.skeleton, &given, &mut frames)
        .unwrap();
    let expected = file.skinned(world);
    let by_world = largest_distance(body, &posed(body, &frames), &expected);
    let skin = &list.skins()[0];
    let bind = file.bind_matrices(&file.document.skins().next().unwrap());
    let skinning: Vec<Mat4> = (skin.joints.iter().zip(bind))
        .map(|(&j, bind)| (world[nodes[j as usize]] * bind).as_mat4())
        .collect();
    list.frames_from_skinning(&body.skeleton, 0, &skinning, &mut frames)
        .unwrap();
    [
        by_world,
        largest_distance(body, &posed(body, &frames), &expected),
    ]
}

/// A hundredth of a millimetre.
const NEAR: f64 = 1e-5;

#[test]
fn clips_of_real_files_are_followed() {
    for name in [
        "khronos-CesiumMan.glb",
        "khronos-RiggedSimple.glb",
        "makehuman-female-cmu-02_01.glb",
    ] {
        let Some(path) = asset(name) else { continue };
        let bytes = std::fs::read(path).unwrap();
        let (file, body) = (Evaluation::new(&bytes), body_of(&bytes));
        assert_eq!(body.up, UpAxis::Y);
        // In the order of the skin.
        let skin = file.document.skins().next().unwrap();
        let order: Vec<&str> = skin.joints().map(|j| j.name().unwrap()).collect();
        let names: Vec<&str> = body.joints.joints().iter().map(|j| &*j.name).collect();
        assert_eq!(names, order);
        let mut largest = [0.0_f64; 2];
        for k in 0..100 {
            let time = file.first_key(0) + 0.03 * f64::from(k);
            let found = distances(&file, &body, &file.animated(0, time));
            largest = std::array::from_fn(|i| largest[i].max(found[i]));
        }
        println!("{name}: {largest:?} m");
        assert!(largest.iter().all(|d| *d < NEAR), "{name}: {largest:?} m");
    }
}

#[test]
fn nodes_turned_at_random_and_multiplied_in_f32_are_followed() {
    for name in [
        "khronos-CesiumMan.glb",
        "makehuman-female-cmu-02_01.glb",
        "webxr-generic-hand-left.glb",
    ] {
        let Some(path) = asset(name) else { continue };
        let bytes = std::fs::read(path).unwrap();
        let (file, body) = (Evaluation::new(&bytes), body_of(&bytes));
        let random = &mut Random::new(17);
        let mut largest: f64 = 0.0;
        for _ in 0..20 {
            let turns: Vec<DQuat> = (file.document.nodes())
                .map(|_| DQuat::from_mat3(&random.rotation(0.5)))
                .collect();
            let mut world = vec![Mat4::IDENTITY; turns.len()];
            // Every product rounds.
            let mut stack: Vec<_> = file.document.default_scene().unwrap().nodes().collect();
            let mut above = vec![Mat4::IDENTITY; turns.len()];
            while let Some(node) = stack.pop() {
                let n = node.index();
                let local = local_rest(&node) * DMat4::from_quat(turns[n]);
                world[n] = above[n] * local.as_mat4();
                for child in node.children() {
                    above[child.index()] = world[n];
                    stack.push(child);
                }
            }
            let world: Vec<DMat4> = world.iter().map(|w| w.as_dmat4()).collect();
            let [distance, _] = distances(&file, &body, &world);
            largest = largest.max(distance);
        }
        println!("{name}: {largest:.1e} m");
        assert!(largest < NEAR, "{name}: {largest:e} m");
    }
}

/// A rig whose armature is a hundredth of its size and turned, as exporters write it, and whose rest is not its bind pose.
fn scaled() -> BarFile {
    BarFile {
        armature: (
            0.01,
            DQuat::from_rotation_x(-1.5),
            DVec3::new(0.3, 1.0, -0.2),
        ),
        bend: [0.2, -0.4, 0.3].map(DQuat::from_rotation_y),
        placement: DMat4::from_scale(DVec3::splat(2.0)),
        ..BarFile::default()
    }
}

#[test]
fn an_armatures_scale_belongs_to_the_bind() {
    let bytes = bar_file(&scaled()).glb();
    let (file, body) = (Evaluation::new(&bytes), body_of(&bytes));
    for joint in body.joints.joints() {
        let scale = joint.bind.matrix3.determinant().cbrt();
        assert!((scale - 0.01).abs() < 1e-9, "{joint:?}");
        assert!(joint.bind.translation.length() < 1e-15, "{joint:?}");
    }
    let random = &mut Random::new(3);
    let turns: Vec<DQuat> = (0..5)
        .map(|_| DQuat::from_mat3(&random.rotation(1.0)))
        .collect();
    let world = file.world(&|n| local_rest(n) * DMat4::from_quat(turns[n.index()]));
    let found = distances(&file, &body, &world);
    // The bar is 3 mm long.
    assert!(found.iter().all(|d| *d < 1e-7), "{found:?} m");
    // A game that makes the character three times as large by its root, baked at that size.
    let mut large = body.clone();
    large.scale(3.0);
    let by_root = DMat4::from_scale(DVec3::splat(3.0));
    let world: Vec<DMat4> = world.iter().map(|w| by_root * *w).collect();
    let found = distances(&file, &large, &world);
    assert!(found.iter().all(|d| *d < 3e-7), "{found:?} m");
}

#[test]
fn other_skins_and_hanging_parts_come_after_the_largest_skin() {
    let mut file = bar_file(&BarFile::default());
    // A second skin of the last joint alone, a skin that nothing shows, and a cube on a node below bone 1.
    let bind = file.json["skins"][0]["inverseBindMatrices"].clone();
    file.json["skins"][0]["joints"] = json!([3, 2, 1]);
    let order = file.json["skins"][0].clone();
    file.json["skins"] =
        json!([{"joints": [1]}, order, {"joints": [3], "inverseBindMatrices": bind}]);
    file.json["nodes"][4]["skin"] = json!(1);
    let plain = json!({"name": "bone 0", "mesh": 0, "translation": [0.0, 0.1, 0.0], "scale": [1.0, 2.0, 1.0]});
    file.push("nodes", plain);
    file.json["nodes"][2]["children"] = json!([3, 5]);
    let body = body_of(&file.glb());
    let joints = body.joints.joints();
    let names: Vec<&str> = joints.iter().map(|j| &*j.name).collect();
    assert_eq!(names, ["bone 2", "bone 1", "bone 0", "bone 0_2"]);
    assert_eq!(joints[0].bone, JointBone::Is(2));
    assert_eq!(joints[3].bone, JointBone::RidesOn(1));
    assert!((joints[3].bind.matrix3.determinant() - 2.0).abs() < 1e-6);
    let skins = body.joints.skins();
    assert_eq!(skins.len(), 3);
    assert!(skins[0].joints.is_empty() && skins[2].joints.is_empty());
    assert_eq!(skins[1].joints, [0, 1, 2]);
    assert_eq!(body.joints.bones(), BONES);
}

#[test]
fn models_of_smpls_layout_have_their_bones_in_the_files_order() {
    let Some(path) = asset("makehuman-female-game_engine-smpl-layout.npz") else {
        return;
    };
    let body = read_character(&path, &Default::default()).unwrap().body;
    assert_eq!(
        (body.up, body.joints.len()),
        (UpAxis::Y, body.skeleton.len())
    );
    assert!((body.joints.joints().iter()).all(|j| matches!(j.bone, JointBone::Is(_))));
}
