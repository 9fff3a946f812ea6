//! Scales of bones: keys that are left out, rest poses that are stretched, or scaled to nothing.

use super::evaluation::{Evaluation, check_rest, largest_distance, posed};
use super::fixture::*;
use glam::{DMat3, DQuat};
use serde_json::json;
use supple_files::{MotionClip, parse_gltf, parse_gltf_motions};

/// A bar whose clip `bend` turns its middle bone.
fn bent() -> Fixture {
    let mut file = bar_file(&BarFile::default());
    let bend = file.animation("bend");
    file.swing(bend, 2, DQuat::from_rotation_z(0.9));
    file
}

fn clips(file: &Fixture) -> Vec<MotionClip> {
    parse_gltf_motions(&file.glb(), "bar.glb").unwrap()
}

fn notes(file: &Fixture) -> Vec<String> {
    parse_gltf(&file.glb(), "bar.glb").unwrap().notes
}

/// Demands equal rotations in all frames of `bend`.
fn check_rotations(found: &MotionClip, plain: &MotionClip) {
    assert_eq!(found.frames.len(), plain.frames.len());
    for (a, b) in found.frames.iter().zip(&plain.frames) {
        for (a, b) in found
            .world_rotations(a)
            .iter()
            .zip(plain.world_rotations(b))
        {
            assert!(a.angle_between(b) < 1e-7, "{a} {b}");
        }
    }
}

#[test]
fn keys_of_scales_are_left_out_and_told() {
    let plain = clips(&bent()).remove(0);
    assert!(plain.notes.is_empty());
    let uniform = |s: f32| vec![s; 3];
    // In a clip of their own, as noise, to nothing and back, uneven, above the joints.
    let cases = [
        (
            1,
            2,
            [uniform(1.0), uniform(1.3)],
            "bone 1 (1.000 to 1.300)",
        ),
        (
            0,
            2,
            [uniform(0.998), uniform(1.002)],
            "bone 1 (0.998 to 1.002)",
        ),
        (
            0,
            3,
            [uniform(1.0), uniform(0.0)],
            "bone 2 (0.000 to 1.000)",
        ),
        (
            0,
            1,
            [vec![1.0, 0.5, 1.0], vec![2.0, 1.0, 1.0]],
            "bone 0 (0.500 to 2.000)",
        ),
        (
            0,
            0,
            [uniform(2.0), uniform(1.0)],
            "armature (1.000 to 2.000)",
        ),
    ];
    for (animation, node, scales, told) in cases {
        let mut file = bent();
        if animation == 1 {
            file.animation("squash");
        }
        file.channel(animation, (node, "scale", "LINEAR"), &[0.0, 1.0], &scales);
        let mut found = clips(&file);
        let name = ["bend", "squash"][animation];
        let [note] = &found[animation].notes[..] else {
            panic!("{told}: {:?}", found[animation].notes)
        };
        assert!(note.contains(name) && note.contains(told), "{note}");
        found[0].notes.clear();
        assert_eq!(found[0], plain, "{told}");
        assert!((found[animation].duration() - 1.0).abs() < 1e-9);
    }
    // A scale that is only written down is none.
    let mut constant = bent();
    let scales = [vec![1.0; 3], vec![1.000_001; 3]];
    constant.channel(0, (1, "scale", "STEP"), &[0.0, 1.0], &scales);
    assert_eq!(clips(&constant)[0], plain);
}

#[test]
fn a_note_names_some_bones_and_counts_the_others() {
    let mut file = bent();
    for k in 0..10 {
        let node = file.push("nodes", json!({"name": format!("twig {k}")}));
        file.json["nodes"][3]["children"] = match k {
            0 => json!([node]),
            _ => (5..=node).collect(),
        };
        file.swing(0, node, DQuat::from_rotation_x(0.1));
        let scales = [vec![1.0; 3], vec![1.1; 3]];
        file.channel(0, (node, "scale", "LINEAR"), &[0.0, 1.0], &scales);
    }
    let clip = clips(&file).remove(0);
    assert!(clip.notes[0].contains("twig 7 ") && clip.notes[0].contains("and 2 others"));
    assert!(!clip.notes[0].contains("twig 8"), "{:?}", clip.notes);
}

#[test]
fn a_stretch_at_rest_is_in_the_shape() {
    let plain = clips(&bent()).remove(0);
    for stretch in [[1.006, 0.988, 1.006], [1.0, 2.0, 1.0]] {
        let mut file = bent();
        file.json["nodes"][2]["scale"] = json!(stretch);
        let body = check_rest(&file.glb());
        let evaluation = Evaluation::new(&file.glb());
        let bind = posed(&body, &body.skeleton.bind_pose());
        let shown = evaluation.skinned(&evaluation.rest());
        assert!(largest_distance(&body, &bind, &shown) < 1e-6);
        let rest = parse_gltf(&file.glb(), "bar.glb").unwrap().rest;
        let rigid = |r: DMat3| (r.transpose() * r).abs_diff_eq(DMat3::IDENTITY, 1e-12);
        assert!(rest.iter().all(|frame| rigid(frame.rotation)));
        check_rotations(&clips(&file)[0], &plain);
        // The bone and the one below it.
        let notes = notes(&file);
        assert!(
            notes.iter().any(|n| n.starts_with("2 bones are stretched")),
            "{notes:?}"
        );
    }
    assert!(notes(&bent()).is_empty());
}

#[test]
fn bones_may_be_scaled_to_nothing_at_rest() {
    let plain = clips(&bent()).remove(0);
    let mut file = bent();
    file.json["nodes"][3]["scale"] = json!([0, 0, 0]);
    let body = check_rest(&file.glb());
    check_rotations(&clips(&file)[0], &plain);
    assert!(
        notes(&file)
            .iter()
            .any(|n| n.starts_with("1 bones are scaled to nothing"))
    );
    // A host's matrices, whose scale is 1 again, are read.
    let mut frames = Vec::new();
    let shown = Evaluation::new(&bent().glb()).rest();
    let world: Vec<glam::Mat4> = [1, 2, 3].map(|n: usize| shown[n].as_mat4()).to_vec();
    let joints = &body.joints;
    joints
        .frames_from_world(&body.skeleton, &world, &mut frames)
        .unwrap();
    let turned = |f: &supple::model::Frame| !f.rotation.abs_diff_eq(DMat3::IDENTITY, 1e-6);
    assert!(!frames.iter().any(turned));
}

#[test]
fn a_bone_mirrored_against_the_others_turns_properly() {
    let plain = clips(&bent()).remove(0);
    let mut file = bent();
    file.json["nodes"][3]["scale"] = json!([-1, 1, 1]);
    let bytes = file.glb();
    let found = parse_gltf(&bytes, "bar.glb").unwrap();
    assert!(
        found
            .rest
            .iter()
            .all(|f| (f.rotation.determinant() - 1.0).abs() < 1e-12)
    );
    let clip = clips(&file).remove(0);
    let (first, last) = (&clip.frames[0], &clip.frames[30]);
    let turn = |c: &MotionClip, f| c.world_rotations(f)[2];
    let found = turn(&clip, last) * turn(&clip, first).inverse();
    let expected = turn(&plain, &plain.frames[30]) * turn(&plain, &plain.frames[0]).inverse();
    assert!(found.angle_between(expected) < 1e-7);
}
