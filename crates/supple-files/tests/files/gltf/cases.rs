//! Small files that once failed, where they are there.

use super::evaluation::check_clips;
use std::path::PathBuf;
use supple_files::{
    BoneMap, CharacterOptions, MapOptions, MotionClip, is_gltf_motion, read_character,
    read_gltf_motions,
};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/cases");

/// The file, or nothing, said aloud, where it is not there.
fn case(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(FOLDER).join(name);
    let there = path.exists();
    if !there {
        println!("skipped: {} is not there", path.display());
    }
    there.then_some(path)
}

fn only_clip(path: &PathBuf, called: &str) -> MotionClip {
    let clips = read_gltf_motions(path).unwrap();
    clips.into_iter().find(|c| c.name == called).unwrap()
}

#[test]
fn clips_beside_scales_play_as_without_them() {
    let Some(path) = case("ok_bend.glb") else {
        return;
    };
    let plain = only_clip(&path, "bend");
    for (name, clip) in [
        ("poisoned_clip.glb", "bend"),
        ("scale_noise.glb", "bend"),
        ("scale_zero.glb", "bend_hide"),
        ("nonuniform_rest.glb", "bend"),
    ] {
        let Some(path) = case(name) else { return };
        read_character(&path, &CharacterOptions::default()).unwrap();
        let found = only_clip(&path, clip);
        assert_eq!(found.bones, plain.bones);
        let (mut turn, mut way): (f64, f64) = (0.0, 0.0);
        for k in 0..=10 {
            let time = 0.1 * f64::from(k) * plain.duration();
            let frames = [&found, &plain].map(|c| c.world_frames(&c.sample(time)));
            for (a, b) in frames[0].iter().zip(&frames[1]) {
                let apart = a.rotation - b.rotation;
                turn = apart
                    .to_cols_array()
                    .iter()
                    .fold(turn, |most, d| most.max(d.abs()));
                way = way.max(a.position.distance(b.position));
            }
        }
        println!("{name}: rotations {turn:.1e}, places {way:.1e} m");
        // A chest 1.2 % shorter at rest bears a head 4.2 mm lower.
        let lower = if name == "nonuniform_rest.glb" {
            0.35 * 0.012
        } else {
            0.0
        };
        assert!(turn < 1e-6 && way < lower + 1e-6);
    }
}

#[test]
fn motions_of_nodes_move_the_bones_of_that_name() {
    let files = ["node_no_joint_motion.glb", "node_joint_avatar.glb"];
    let [Some(motion), Some(avatar)] = files.map(case) else {
        return;
    };
    let clip = only_clip(&motion, "kick");
    let body = read_character(avatar, &CharacterOptions::default())
        .unwrap()
        .body;
    let map = BoneMap::new(&clip.bones, &body.skeleton, &MapOptions::default()).unwrap();
    let driven = |&(_, t): &(usize, usize)| body.skeleton.names[t] == "thigh_l";
    assert!(map.pairs.iter().any(driven), "{}", map.summary());
}

#[test]
fn files_without_a_body_are_motions() {
    for (name, bones) in [
        ("animation_only.glb", ["hips", "chest", "head"]),
        ("minimal.vrma", ["hips", "spine", "head"]),
        ("rigid_nodes_no_skin.glb", ["hips", "chest", "head"]),
    ] {
        let Some(path) = case(name) else { return };
        let clips = read_gltf_motions(&path).unwrap();
        assert_eq!(clips[0].bones, bones, "{name}");
        assert_eq!(
            is_gltf_motion(&path).unwrap(),
            name != "rigid_nodes_no_skin.glb"
        );
        if !name.ends_with("vrma") {
            check_clips(&std::fs::read(&path).unwrap());
        }
    }
}

#[test]
fn required_extensions_of_materials_are_no_hindrance() {
    let options = CharacterOptions::default();
    if let Some(path) = case("required_KHR_materials_pbrSpecularGlossiness.glb") {
        read_character(path, &options).unwrap();
    }
    if let Some(path) = case("draco.glb") {
        read_character(path, &options).unwrap();
    }
}
