//! Bones that are no joints of a drawn skin: of motions, of VRM, and of files without a skin.

use super::evaluation::{Evaluation, check_clips, check_rest, largest_distance, posed};
use super::fixture::*;
use glam::DQuat;
use serde_json::json;
use supple::model::JointBone;
use supple_bake::{Recipe, bake};
use supple_files::{
    BoneMap, ClipOptions, ClipPlayer, MapOptions, is_gltf_motion, parse_gltf, parse_gltf_motions,
};

const TURN: f64 = 0.8;

/// A node below `parent`, 0.1 m along its y.
fn hang(file: &mut Fixture, parent: usize, name: &str) -> usize {
    let node = file.push("nodes", json!({"name": name, "translation": [0, 0.1, 0]}));
    let children = &mut file.json["nodes"][parent]["children"];
    match children.as_array_mut() {
        Some(list) => list.push(json!(node)),
        None => *children = json!([node]),
    }
    node
}

/// A bar with a limb of two nodes on its middle bone, of which the clip `kick` turns the second.
fn limb() -> (Fixture, usize) {
    let mut file = bar_file(&BarFile::default());
    let twist = hang(&mut file, 2, "twist");
    let limb = hang(&mut file, twist, "limb");
    hang(&mut file, limb, "end");
    let kick = file.animation("kick");
    file.swing(kick, limb, DQuat::from_rotation_x(TURN));
    file.swing(kick, 3, DQuat::from_rotation_z(0.3));
    (file, limb)
}

/// `file` without what it shows.
fn motion_alone(mut file: Fixture) -> Fixture {
    file.json["meshes"] = json!([]);
    file.json["skins"] = json!([]);
    file.json["nodes"][4] = json!({"name": "mesh"});
    file
}

#[test]
fn a_motion_has_all_bones_that_are_moved_and_those_between() {
    let (file, _) = limb();
    let clip = check_clips(&file.glb()).remove(0);
    let mut names = clip.bones.clone();
    names.sort();
    assert_eq!(names, ["bone 0", "bone 1", "bone 2", "limb", "twist"]);
    let parent = |name: &str| {
        let p = clip.parents[clip.find(name).unwrap()];
        &*clip.bones[p.unwrap() as usize]
    };
    assert_eq!((parent("limb"), parent("twist")), ("twist", "bone 1"));
    assert!(clip.translated.is_empty(), "no bone slides");
    // The body has none of them: its skin is not moved by them.
    let body = check_rest(&file.glb());
    assert_eq!(body.skeleton.names, ["bone 0", "bone 1", "bone 2"]);
}

#[test]
fn a_node_above_the_joints_is_a_bone_of_the_motion() {
    let mut file = bar_file(&BarFile::default());
    file.animation("glide");
    let pivot = file.push("nodes", json!({"name": "pivot", "children": [1]}));
    file.json["nodes"][0]["children"] = json!([pivot, 4]);
    let path = [vec![0.0, 0.0, 0.0], vec![0.5, 0.0, 0.2]];
    file.channel(0, (0, "translation", "LINEAR"), &[0.0, 1.0], &path);
    let clip = check_clips(&file.glb()).remove(0);
    let parent = |name: &str| clip.parents[clip.find(name).unwrap()].map(|p| p as usize);
    assert_eq!(parent("bone 0"), clip.find("pivot"));
    assert_eq!(parent("pivot"), clip.find("armature"));
}

#[test]
fn a_file_that_shows_nothing_is_a_motion_of_all_its_nodes() {
    let (file, _) = limb();
    let bytes = motion_alone(file).glb();
    let clip = check_clips(&bytes).remove(0);
    assert_eq!(clip.bones.len(), 8);
    assert_eq!(clip.parents.iter().filter(|p| p.is_none()).count(), 1);
    let error = parse_gltf(&bytes, "kick.glb").unwrap_err().to_string();
    assert!(
        error.contains("meshes") && error.contains("--avatar"),
        "{error}"
    );
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes, alone) in [("a.glb", bytes, true), ("b.glb", limb().0.glb(), false)] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        assert_eq!(is_gltf_motion(&path).unwrap(), alone);
    }
}

#[test]
fn more_nodes_than_a_motion_has_are_refused_or_left_out() {
    let mut file = motion_alone(bar_file(&BarFile::default()));
    let clip = file.animation("move");
    file.swing(clip, 2, DQuat::from_rotation_x(0.5));
    let first = 5;
    for _ in 0..5000 {
        file.push("nodes", json!({"translation": [0, 0.1, 0]}));
    }
    file.json["nodes"][3]["children"] = (first..first + 5000).collect();
    // Too many to take them all: what is moved, and no more.
    let found = parse_gltf_motions(&file.glb(), "crowd.glb").unwrap();
    assert_eq!(found[0].bones, ["bone 1"]);
    let channel = file.json["animations"][0]["channels"][0].clone();
    for node in first..first + 5000 {
        let mut channel = channel.clone();
        channel["target"]["node"] = json!(node);
        file.json["animations"][0]["channels"]
            .as_array_mut()
            .unwrap()
            .push(channel);
    }
    let error = parse_gltf_motions(&file.glb(), "crowd.glb")
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("animations") && error.contains("5002"),
        "{error}"
    );
}

#[test]
fn vrm_animations_have_the_names_of_vrm_and_play_on_its_avatars() {
    let (shown, limb) = limb();
    let mut file = motion_alone(shown.clone());
    let face = file.push("nodes", json!({"name": "happy"}));
    file.json["scenes"][0]["nodes"] = json!([0, face]);
    let shift = [vec![0.0; 3], vec![1.0, 0.0, 0.0]];
    file.channel(0, (face, "translation", "LINEAR"), &[0.0, 1.0], &shift);
    file.json["extensions"]["VRMC_vrm_animation"] = json!({
        "specVersion": "1.0",
        "humanoid": {"humanBones": {
            "hips": {"node": 1}, "spine": {"node": 2}, "leftUpperLeg": {"node": limb},
            "head": {"node": 99}, "neck": {},
        }},
        "expressions": {"preset": {"happy": {"node": face}}},
    });
    let bytes = file.glb();
    let clip = parse_gltf_motions(&bytes, "kick.vrma").unwrap().remove(0);
    assert_eq!(clip.bones, ["hips", "spine", "twist", "leftUpperLeg"]);

    // The names are those also where the file shows a body, which has its own.
    let mut shown = shown;
    shown.json["extensions"] = file.json["extensions"].clone();
    let own = parse_gltf_motions(&shown.glb(), "kick.vrma")
        .unwrap()
        .remove(0);
    assert_eq!(
        own.bones,
        ["hips", "spine", "bone 2", "twist", "leftUpperLeg"]
    );

    // An avatar whose leg is no joint, and no bone but for its name.
    let mut avatar = bar_file(&BarFile::default());
    let upper = hang(&mut avatar, 2, "x1");
    let upper = hang(&mut avatar, upper, "x2");
    avatar.json["extensions"]["VRMC_vrm"] = json!({
        "specVersion": "1.0",
        "humanoid": {"humanBones": {
            "hips": {"node": 1}, "spine": {"node": 2}, "leftUpperLeg": {"node": upper},
        }},
    });
    let body = check_rest(&avatar.glb());
    assert_eq!(body.skeleton.names, ["bone 0", "bone 1", "bone 2", "x2"]);
    let leg = body.skeleton.find("leftUpperLeg").unwrap();
    assert_eq!(body.skeleton.parents[leg], Some(1));
    assert!(
        body.joints
            .joints()
            .iter()
            .any(|j| j.bone == JointBone::Is(leg as u32))
    );
    let map = BoneMap::new(&clip.bones, &body.skeleton, &MapOptions::default()).unwrap();
    assert_eq!(
        (map.pairs.len(), &map.unmapped_source[..]),
        (3, &["twist".to_string()][..])
    );
    let player = ClipPlayer::new(clip, &body.skeleton, &ClipOptions::default()).unwrap();
    let local = |time: f64| {
        let frames = player.frames(time);
        DQuat::from_mat3(&(frames[1].rotation.transpose() * frames[leg].rotation))
    };
    let angle = local(0.0).angle_between(local(0.5));
    assert!((angle - TURN).abs() < 1e-6, "{angle}");
    // A bone that moves no skin bakes with the others.
    bake(&body, &Recipe::default(), &mut |_| ()).unwrap();
}

/// Three bars, each on a node of its own below the one before, of which a clip turns the second; a lamp that a clip moves
/// and a plate that stands still, beside them.
fn figure() -> Fixture {
    let mut file = Fixture::new();
    let bar = Bar::new(6, 0.05);
    let triangles = bar.triangles.as_flattened();
    let positions = file.vectors(&bar.positions);
    let indices = file.shorts("SCALAR", triangles.len(), triangles);
    let primitive = json!({"attributes": {"POSITION": positions}, "indices": indices});
    file.push("meshes", json!({"primitives": [primitive]}));
    let nodes = [
        json!({"name": "hips", "mesh": 0, "children": [1], "translation": [0, 1, 0]}),
        json!({"name": "chest", "mesh": 0, "children": [2], "translation": [0.6, 0, 0],
            "rotation": DQuat::from_rotation_y(0.4).to_array(), "scale": [0.9, 0.9, 0.9]}),
        json!({"name": "pole", "children": [3], "translation": [0.6, 0, 0]}),
        json!({"name": "head", "mesh": 0, "translation": [0.1, 0, 0]}),
        json!({"name": "lamp", "translation": [0, 3, 0], "children": [6]}),
        json!({"name": "plate", "mesh": 0, "translation": [0, -1, 0]}),
        json!({"name": "shade", "translation": [0, 0.2, 0]}),
    ];
    for node in nodes {
        file.push("nodes", node);
    }
    file.json["scenes"][0]["nodes"] = json!([0, 4, 5]);
    let bend = file.animation("bend");
    file.swing(bend, 1, DQuat::from_rotation_z(TURN));
    file.swing(bend, 4, DQuat::from_rotation_z(TURN));
    file
}

#[test]
fn without_a_skin_nodes_are_bones_and_parts_are_rigid_on_them() {
    let bytes = figure().glb();
    let body = check_rest(&bytes);
    let skeleton = &body.skeleton;
    // The pole is between; the lamp shows nothing and holds nothing.
    assert_eq!(skeleton.names, ["hips", "plate", "chest", "pole", "head"]);
    assert_eq!(skeleton.parents, [None, Some(0), Some(0), Some(2), Some(3)]);
    assert_eq!(body.render_meshes.len(), 4);
    assert_eq!(body.joints.joints().len(), 5);
    let file = Evaluation::new(&bytes);
    let clip = check_clips(&bytes).remove(0);
    assert!(
        clip.find("shade").is_some(),
        "the tree of the lamp is one of the motion's"
    );
    for (f, frame) in clip.frames.iter().enumerate().step_by(9) {
        let frames = super::evaluation::frames_of(&body, &clip, frame);
        let expected = file.skinned(&file.animated(0, clip.frame_time * f as f64));
        assert!(largest_distance(&body, &posed(&body, &frames), &expected) < 1e-6);
    }
    let middle = clip.sample(0.5);
    let chest = clip.world_rotations(&middle)[clip.find("chest").unwrap()];
    assert!((chest.angle_between(DQuat::IDENTITY) - TURN).abs() < 1e-6);
    let notes = parse_gltf(&bytes, "figure.glb").unwrap().notes;
    assert!(
        notes
            .iter()
            .any(|n| n.contains("no skin") && n.contains("5 nodes")),
        "{notes:?}"
    );
    // Its one closed part of most volume is soft, the others hang on their bones.
    bake(&body, &Recipe::default(), &mut |_| ()).unwrap();
}

#[test]
fn hidden_nodes_show_nothing() {
    for (visibility, parts) in [(json!({"visible": false}), 2), (json!({}), 4)] {
        let mut file = figure();
        file.json["nodes"][1]["extensions"]["KHR_node_visibility"] = visibility;
        let body = parse_gltf(&file.glb(), "figure.glb")
            .unwrap()
            .body(&[])
            .unwrap();
        assert_eq!(body.render_meshes.len(), parts);
    }
}
