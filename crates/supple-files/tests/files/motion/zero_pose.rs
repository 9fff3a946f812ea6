//! Zero poses that are no figure: local axes along the bones, as many recorders have them.

use super::retarget::{player, smpl};
use std::path::Path;
use supple::glam::{DQuat, DVec3};
use supple::internal::math::Random;
use supple::model::{Skeleton, UpAxis};
use supple_files::{
    BvhOptions, ClipOptions, MotionClip, MotionFrame, RetargetOptions, bvh_text, parse_bvh,
    read_bvh,
};
use supple_samples::{body, walk};

/// `clip` with joints at the same places in every frame, and bone j at rest turned by `turns[j]`⁻¹.
fn rebased(clip: &MotionClip, turns: &[DQuat]) -> MotionClip {
    let above = |j: usize| clip.parents[j].map_or(DQuat::IDENTITY, |p| turns[p as usize]);
    let rest = clip.rest_joints.as_ref().unwrap();
    let mut joints: Vec<DVec3> = Vec::new();
    for (j, parent) in clip.parents.iter().enumerate() {
        joints.push(match parent.map(|p| p as usize) {
            None => rest[j],
            Some(p) => joints[p] + turns[p].inverse() * (rest[j] - rest[p]),
        });
    }
    let frame = |f: &MotionFrame| MotionFrame {
        translations: f.translations.clone(),
        rotations: (f.rotations.iter().enumerate())
            .map(|(j, r)| (above(j).inverse() * *r * turns[j]).normalize())
            .collect(),
    };
    MotionClip {
        rest_joints: Some(joints),
        frames: clip.frames.iter().map(frame).collect(),
        ..clip.clone()
    }
}

/// Turns that take `axis(j)` to the direction of bone j, from its joint to its first child; the pelvis has none.
fn along_bones(clip: &MotionClip, axis: impl Fn(&str) -> DVec3) -> Vec<DQuat> {
    let mut random = Random::new(4);
    let rest = clip.rest_joints.as_ref().unwrap();
    let turn = |j: usize| {
        let child = (clip.parents.iter()).position(|p| *p == Some(j as u32));
        let (Some(child), true) = (child, j > 0) else {
            return DQuat::IDENTITY;
        };
        // About the bone any angle will do.
        let bone = (rest[child] - rest[j]).normalize();
        let about = DQuat::from_axis_angle(bone, random.uniform(-3.0, 3.0));
        about * DQuat::from_rotation_arc(axis(&clip.bones[j]), bone)
    };
    (0..clip.bones.len()).map(turn).collect()
}

/// Checks that every joint of `skeleton`, whose y points up, is within 1 cm of where it is by the other clip, over all
/// of it. A hand's end is within 1.6 cm: how the zero pose that is missing held the hand, no pose tells.
fn check_alike(a: &MotionClip, b: &MotionClip, skeleton: &Skeleton) {
    let options = ClipOptions {
        retarget: RetargetOptions {
            avatar_up: Some(UpAxis::Y),
            ..RetargetOptions::default()
        },
        ..ClipOptions::default()
    };
    let [a, b] = [a, b].map(|c| player(c.clone(), skeleton, &options));
    for k in 0..=40 {
        let time = f64::from(k) / 40.0 * a.clip().duration();
        let (a, b) = (a.frames(time), b.frames(time));
        for ((p, q), bone) in a.iter().zip(b).zip(&skeleton.names) {
            let most = if bone.ends_with("hand") { 0.016 } else { 0.01 };
            let miss = (p.position - q.position).length();
            assert!(miss < most, "{bone}: {miss} m");
        }
    }
}

/// Whichever axis lies along the bones, the avatar moves as by the clip whose zero pose is a figure.
#[test]
fn axes_along_the_bones_move_an_avatar_alike() {
    let plain = walk();
    let mirrored = |bone: &str| match bone.starts_with("right") {
        true => -DVec3::X,
        false => DVec3::X,
    };
    for avatar in [smpl(), body().unwrap().model.skeleton(&[])] {
        for aligned in [
            along_bones(&plain, |_| DVec3::X),
            along_bones(&plain, |_| DVec3::Y),
            along_bones(&plain, |_| -DVec3::Z),
            along_bones(&plain, mirrored),
        ] {
            let aligned = rebased(&plain, &aligned);
            check_alike(&plain, &aligned, &avatar);
            let read = player(aligned, &avatar, &ClipOptions::default());
            let said = read.clip().notes.concat();
            assert!(said.contains("zero pose is no figure"), "{said}");
        }
    }
}

/// Up is where the poses reach, where the zero pose is a line along y.
#[test]
fn the_axis_up_is_told_by_the_poses() {
    let mut clip = walk();
    // The walk with z up, as x → x, y → z, z → −y.
    let up = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    for joint in clip.rest_joints.as_mut().unwrap() {
        *joint = up * *joint;
    }
    for frame in &mut clip.frames {
        frame.translations[0] = up * frame.translations[0];
        for rotation in &mut frame.rotations {
            *rotation = up * *rotation * up.inverse();
        }
    }
    let clip = rebased(&clip, &along_bones(&clip, |_| DVec3::Y));
    let read = parse_bvh(
        &bvh_text(&clip),
        Path::new("walk.bvh"),
        &BvhOptions::default(),
    );
    let read = read.unwrap();
    assert_eq!((read.rest_up, read.world_up), (UpAxis::Z, UpAxis::Z));
}

/// The same walk in two files, where they are there.
#[test]
fn a_recorded_pair_moves_an_avatar_alike() {
    let folder = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/cases"
    ));
    if !folder.exists() {
        eprintln!("skipped: {} is not there", folder.display());
        return;
    }
    let read = |name: &str| read_bvh(folder.join(name), &BvhOptions::default()).unwrap();
    let [plain, aligned] = ["walk_plain.bvh", "walk_bone_aligned.bvh"].map(read);
    for avatar in [smpl(), body().unwrap().model.skeleton(&[])] {
        check_alike(&plain, &aligned, &avatar);
    }
}
