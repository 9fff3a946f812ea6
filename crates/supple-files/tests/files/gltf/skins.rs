//! Hierarchies, rest rotations, bind matrices, scales, several skins, kinds of weights.

use super::evaluation::check_rest;
use super::fixture::*;
use glam::{DMat4, DQuat, DVec3};
use serde_json::json;
use supple_files::parse_gltf;

fn placed() -> BarFile {
    BarFile {
        armature: (
            0.01,
            DQuat::from_rotation_x(-1.5),
            DVec3::new(0.3, 1.0, -0.2),
        ),
        ..BarFile::default()
    }
}

fn bent() -> [DQuat; BONES] {
    [
        DQuat::from_rotation_y(0.3),
        DQuat::from_rotation_z(0.8),
        DQuat::from_rotation_x(-0.5),
    ]
}

#[test]
fn rest_rotations_and_placements_above_the_joints() {
    let body = check_rest(&bar_file(&BarFile::default()).glb());
    assert!(body.skin.is_closed() && body.skin.volume() > 0.0);
    assert_eq!(body.skeleton.parents, [None, Some(0), Some(1)]);
    for (j, joint) in body.skeleton.joints.iter().enumerate() {
        let expected = DVec3::X * (LENGTH * j as f64 / BONES as f64);
        assert!(joint.distance(expected) < 1e-6, "{joint} {expected}");
    }
    let small = check_rest(&bar_file(&placed()).glb());
    let ratio = small.skin.volume() / body.skin.volume();
    assert!(
        (ratio / 1e-6 - 1.0).abs() < 1e-5,
        "the scale is in the shape: {ratio}"
    );
}

#[test]
fn a_rest_pose_other_than_the_bind_pose_is_met_and_undone() {
    let bind = parse_gltf(&bar_file(&placed()).glb(), "bar.glb").unwrap();
    let file = bar_file(&BarFile {
        bend: bent(),
        ..placed()
    });
    let bytes = file.glb();
    let body = check_rest(&bytes);
    let character = parse_gltf(&bytes, "bar.glb").unwrap();
    // The reference shape is the bind pose's, turned as the root is at rest.
    let straight = bind.body(&[]).unwrap();
    let root = character.rest[0].rotation;
    let turned = joint_worlds(Default::default(), &bent())[0].matrix3;
    let bind_turn = joint_worlds(Default::default(), &[DQuat::IDENTITY; BONES])[0].matrix3;
    let armature = glam::DMat3::from_quat(placed().armature.1);
    let turn = armature * turned * bind_turn.transpose() * armature.transpose();
    assert!((root - glam::DMat3::IDENTITY).abs_diff_eq(glam::DMat3::ZERO, 1e-6));
    for (x, y) in body.skin.positions.iter().zip(&straight.skin.positions) {
        let expected = turn * (*y - straight.skeleton.joints[0]) + body.skeleton.joints[0];
        assert!(x.distance(expected) < 1e-8, "{x} {expected}");
    }
}

#[test]
fn absent_bind_matrices_are_the_identity() {
    let mut file = bar_file(&BarFile {
        bend: [DQuat::IDENTITY; BONES],
        ..BarFile::default()
    });
    file.json["skins"][0]
        .as_object_mut()
        .unwrap()
        .remove("inverseBindMatrices");
    check_rest(&file.glb());
}

#[test]
fn a_mirrored_placement_keeps_the_skin_facing_outward() {
    // In the bind pose, the mesh being inside out in its own coordinates; and in the scene.
    let bound = bar_file(&BarFile {
        placement: DMat4::from_scale(DVec3::new(-2.0, 2.0, 2.0)),
        ..placed()
    });
    let mut shown = bar_file(&placed());
    shown.json["nodes"][0]["scale"] = json!([-0.01, 0.01, 0.01]);
    for file in [bound, shown] {
        let body = check_rest(&file.glb());
        assert!(body.skin.is_closed());
        assert!(body.skin.volume() > 0.0, "{}", body.skin.volume());
    }
}

#[test]
fn two_skins_with_placements_of_their_own_share_the_bones() {
    let mut file = bar_file(&placed());
    // A second mesh, bound in centimetres and other axes, on joints in another order.
    let other = DMat4::from_scale_rotation_translation(
        DVec3::splat(0.01),
        DQuat::from_rotation_y(0.9),
        DVec3::new(0.1, 0.2, 0.3),
    );
    let bind = joint_worlds(Default::default(), &[DQuat::IDENTITY; BONES]);
    let inverse = [2, 0, 1].map(|j: usize| DMat4::from(bind[j].inverse()) * other);
    let inverse = file.matrices(&inverse);
    file.push(
        "skins",
        json!({"joints": [3, 1, 2], "inverseBindMatrices": inverse}),
    );
    let bar = Bar::new(6, 0.03);
    let back = other.inverse();
    let shifted = |p: &DVec3| back.transform_point3(*p + DVec3::Y * 0.2);
    let positions: Vec<DVec3> = bar.positions.iter().map(shifted).collect();
    let joints: Vec<[u8; 4]> = bar
        .influences()
        .0
        .iter()
        .map(|j| j.map(|j| (j + 1) % 3))
        .collect();
    let attributes = json!({
        "POSITION": file.vectors(&positions),
        "JOINTS_0": file.accessor(BYTE, "VEC4", joints.len(), joints.as_flattened()),
        "WEIGHTS_0": file.floats("VEC4", &bar.influences().1),
    });
    let indices = file.shorts(
        "SCALAR",
        3 * bar.triangles.len(),
        bar.triangles.as_flattened(),
    );
    let primitive = json!({"attributes": attributes, "indices": indices});
    file.push(
        "meshes",
        json!({"name": "second", "primitives": [primitive]}),
    );
    let node = file.push(
        "nodes",
        json!({"mesh": 1, "skin": 1, "translation": [5, 5, 5]}),
    );
    file.json["scenes"][0]["nodes"] = json!([0, node]);
    let body = check_rest(&file.glb());
    assert_eq!(body.skeleton.len(), BONES);
    assert_eq!(body.render_meshes.len(), 2);
}

#[test]
fn a_bone_scaled_differently_still_rests_as_the_file_has_it() {
    let mut file = bar_file(&placed());
    file.json["nodes"][2]["scale"] = json!([1.3, 1.3, 1.3]);
    check_rest(&file.glb());
}

#[test]
fn weights_in_bytes_shorts_and_two_sets() {
    let plain = bar_file(&placed());
    let (_, weights) = Bar::new(10, 0.05).influences();
    let quantised = |most: f32| -> Vec<[u16; 4]> {
        let part = |w: &[f32; 4]| {
            let first = (w[0] * most).round() as u16;
            [first, most as u16 - first, 0, 0]
        };
        weights.iter().map(part).collect()
    };
    let mut short = plain.clone();
    let all = quantised(65535.0);
    let accessor = short.shorts("VEC4", all.len(), all.as_flattened());
    short.json["accessors"][accessor]["normalized"] = json!(true);
    short.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(accessor);
    check_rest(&short.glb());

    let mut byte = plain.clone();
    let all: Vec<u8> = quantised(255.0)
        .as_flattened()
        .iter()
        .map(|w| *w as u8)
        .collect();
    let accessor = byte.accessor(BYTE, "VEC4", all.len() / 4, &all);
    byte.json["accessors"][accessor]["normalized"] = json!(true);
    byte.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(accessor);
    check_rest(&byte.glb());

    // The second influence in a set of its own.
    let mut two = plain.clone();
    let first: Vec<[f32; 4]> = weights.iter().map(|w| [w[0], 0.0, 0.0, 0.0]).collect();
    let second: Vec<[f32; 4]> = weights.iter().map(|w| [0.0, w[1], 0.0, 0.0]).collect();
    let attributes = [two.floats("VEC4", &first), two.floats("VEC4", &second)];
    let primitive = &mut two.json["meshes"][0]["primitives"][0]["attributes"];
    primitive["WEIGHTS_0"] = json!(attributes[0]);
    primitive["WEIGHTS_1"] = json!(attributes[1]);
    primitive["JOINTS_1"] = primitive["JOINTS_0"].clone();
    let body = check_rest(&two.glb());
    assert_eq!(body.skinning.longest(), 2);
}

#[test]
fn a_bare_mesh_is_one_bone_and_a_mesh_under_a_joint_is_its() {
    let mut bare = bar_file(&placed());
    bare.json["nodes"][4]
        .as_object_mut()
        .unwrap()
        .remove("skin");
    let body = check_rest(&bare.glb());
    assert_eq!(body.skeleton.len(), 1);

    let mut hung = bar_file(&placed());
    let eye = hung.push("nodes", json!({"mesh": 0, "scale": [0.1, 0.1, 0.1]}));
    hung.json["nodes"][3]["children"] = json!([eye]);
    let body = check_rest(&hung.glb());
    let [eye] = &body.attachments[..] else {
        panic!("{} attachments", body.attachments.len())
    };
    assert!(!eye.follows_tissue);
    let on_tip = |w: &supple::model::SkinWeight| w.bone == 2 && w.weight == 1.0;
    assert!(eye.skinning.entries().iter().all(on_tip));
}
