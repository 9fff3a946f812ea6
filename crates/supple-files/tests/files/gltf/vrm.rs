//! VRM 0.x and 1.0: bone names and colliders.

use super::fixture::*;
use glam::{DQuat, DVec3};
use serde_json::json;
use supple::model::SpringCollider;
use supple_files::gltf::Character;
use supple_files::parse_gltf;

const ARMATURE: (f64, DQuat, DVec3) = (2.0, DQuat::IDENTITY, DVec3::Y);

fn bar() -> Fixture {
    bar_file(&BarFile {
        armature: ARMATURE,
        ..BarFile::default()
    })
}

fn read(file: &Fixture) -> Character {
    parse_gltf(&file.glb(), "figure.vrm").unwrap()
}

/// Where a collider's middles are in the rest pose.
fn places(character: &Character, collider: &SpringCollider) -> Vec<DVec3> {
    let bone = &character.rest[collider.bone as usize];
    let middles = [Some(collider.offset), collider.tail];
    middles
        .into_iter()
        .flatten()
        .map(|p| bone.transform(p))
        .collect()
}

#[test]
fn version_0() {
    let mut file = bar();
    file.json["extensions"]["VRM"] = json!({
        "specVersion": "0.0",
        "humanoid": {"humanBones": [
            {"bone": "hips", "node": 1}, {"bone": "spine", "node": 2}, {"bone": "head", "node": 77},
        ]},
        "secondaryAnimation": {"colliderGroups": [
            {"node": 2, "colliders": [{"offset": {"x": 0.01, "y": 0.02, "z": -0.03}, "radius": 0.05}]},
            {"node": 0, "colliders": [{"offset": {"x": 0, "y": 0, "z": 0}, "radius": 0.05}]},
        ]},
    });
    let character = read(&file);
    let body = character.body(&[]).unwrap();
    assert_eq!(body.skeleton.find("hips"), Some(0));
    assert_eq!(body.skeleton.find("spine"), Some(1));
    assert_eq!(body.skeleton.find("bone 1"), Some(1));
    assert_eq!(body.skeleton.find("head"), None);
    assert_eq!(character.faces, DVec3::NEG_Z);
    // The head that is not there, and the collider above all bones.
    for word in ["humanoid", "colliders"] {
        let told = |n: &String| n.starts_with("1 ") && n.contains(word);
        assert!(character.notes.iter().any(told), "{:?}", character.notes);
    }
    let [sphere] = &body.springs.colliders[..] else {
        panic!()
    };
    let armature = glam::DAffine3::from_scale_rotation_translation(
        DVec3::splat(ARMATURE.0),
        ARMATURE.1,
        ARMATURE.2,
    );
    let node = joint_worlds(armature, &[DQuat::IDENTITY; BONES])[1];
    // z points the other way in this version.
    let expected = node.transform_point3(DVec3::new(0.01, 0.02, 0.03));
    assert!(places(&character, sphere)[0].distance(expected) < 1e-6);
    assert!((sphere.radius - 0.1).abs() < 1e-6 && sphere.tail.is_none());
}

#[test]
fn version_1() {
    let mut file = bar();
    file.json["extensions"]["VRMC_vrm"] = json!({
        "specVersion": "1.0",
        "humanoid": {"humanBones": {"hips": {"node": 1}, "leftUpperArm": {"node": 3}}},
    });
    file.json["extensions"]["VRMC_springBone"] = json!({
        "specVersion": "1.0",
        "colliders": [
            {"node": 3, "shape": {"sphere": {"offset": [0.01, 0.02, 0.03], "radius": 0.04}}},
            {"node": 1, "shape": {"capsule": {"offset": [0, 0, 0], "radius": 0.03, "tail": [0.1, 0, 0]}}},
            {"node": 1, "shape": {}},
        ],
        "colliderGroups": [{"name": "arm", "colliders": [0]}],
    });
    let character = read(&file);
    let body = character.body(&[]).unwrap();
    assert_eq!(body.skeleton.find("leftUpperArm"), Some(2));
    assert_eq!(character.faces, DVec3::Z);
    let [sphere, capsule] = &body.springs.colliders[..] else {
        panic!()
    };
    let armature = glam::DAffine3::from_scale_rotation_translation(
        DVec3::splat(ARMATURE.0),
        ARMATURE.1,
        ARMATURE.2,
    );
    let nodes = joint_worlds(armature, &[DQuat::IDENTITY; BONES]);
    let expected = nodes[2].transform_point3(DVec3::new(0.01, 0.02, 0.03));
    assert!(places(&character, sphere)[0].distance(expected) < 1e-6);
    let expected = nodes[0].transform_point3(DVec3::X * 0.1);
    assert!(places(&character, capsule)[1].distance(expected) < 1e-6);
    assert!((capsule.radius - 0.06).abs() < 1e-6);
}

#[test]
fn spoiled_extensions_cost_nothing_else() {
    for spoiled in [
        json!(1),
        json!({"humanoid": []}),
        json!({"humanoid": {"humanBones": {"a": 3}}}),
    ] {
        for name in ["VRM", "VRMC_vrm", "VRMC_springBone"] {
            let mut file = bar();
            file.json["extensions"][name] = spoiled.clone();
            assert!(read(&file).body(&[]).unwrap().skin.is_closed());
        }
    }
}
