//! Real recordings, where they are there: `../shared/assets`.

use std::path::{Path, PathBuf};
use supple::glam::{DMat3, DVec3};
use supple::internal::math::rotation_log;
use supple::model::{Frame, UpAxis};
use supple_files::{Align, read_character, read_gltf_motions};
use supple_scene::{Playback, TrackedMotion};

fn asset(name: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/assets"
    ))
    .join(name);
    if !path.exists() {
        eprintln!("skipped: {} is not there", path.display());
        return None;
    }
    Some(path)
}

/// The walk as CMU recorded it, brought to a character by us, and by another program: its own animation.
#[test]
fn the_walk_is_the_same_from_bvh_and_glb() {
    let (Some(bvh), Some(glb)) = (
        asset("motion/cmu_orig_02_01.bvh"),
        asset("makehuman-female-cmu-02_01.glb"),
    ) else {
        return;
    };
    let skeleton = read_character(&glb, &Default::default())
        .unwrap()
        .body
        .skeleton;
    let own = read_gltf_motions(&glb).unwrap().remove(0);
    let motion = TrackedMotion {
        origin: Some(supple_files::Origin::Motion),
        ..TrackedMotion::of_file(&bvh)
    };
    let mut playback = Playback::open(&motion, &skeleton, UpAxis::Y, UpAxis::Y).unwrap();
    let hips = (own.find("Hips").unwrap(), skeleton.find("Hips").unwrap());
    let way = |from: DVec3, to: DVec3| (to - from).length();
    let (mut ends, mut sum) = (Vec::new(), 0.0);
    for k in 0..=20 {
        let time = f64::from(k) / 20.0 * own.duration();
        let expected = own.world_frames(&own.sample(time));
        let found = playback.frames(time).unwrap();
        let (a, b) = (expected[hips.0].position, found[hips.1].position);
        ends.push((a, b));
        for (j, bone) in skeleton.names.iter().enumerate() {
            // The recording's fingers have no length: each program holds the hand as it likes. The
            // animation has half the frames, and a leg makes 3 cm in one of them.
            let finger = ["Thumb", "Finger"].iter().any(|part| bone.contains(part));
            let there = own.find(bone).unwrap();
            let miss = (expected[there].position - a) - (found[j].position - b);
            if !finger {
                sum += miss.length() / (21.0 * skeleton.len() as f64);
            }
            assert!(
                finger || miss.length() < 0.015,
                "{bone} at {time} s: {miss}"
            );
        }
    }
    assert!(sum < 2e-3, "{sum} m on average");
    // The way over the ground, scaled by the legs; the other program's own scale is within 2 %.
    let (first, last) = (ends[0], ends[20]);
    let ratio = way(first.1, last.1) / way(first.0, last.0);
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
}

/// The character's own animation, brought to it by its own names, is its own animation.
#[test]
fn a_character_s_own_clip_is_exact() {
    for name in ["makehuman-female-cmu-02_01.glb", "khronos-CesiumMan.glb"] {
        let Some(path) = asset(name) else { continue };
        let body = read_character(&path, &Default::default()).unwrap().body;
        let clip = read_gltf_motions(&path).unwrap().remove(0);
        let motion = TrackedMotion {
            align: Align::None,
            scale: Some(1.0),
            origin: Some(supple_files::Origin::Motion),
            ..TrackedMotion::of_file(&path)
        };
        let mut playback = Playback::open(&motion, &body.skeleton, UpAxis::Y, UpAxis::Y).unwrap();
        for k in [0, 3, 11] {
            let time = f64::from(k) / 11.0 * clip.duration();
            let expected = clip.world_frames(&clip.sample(time));
            let found = playback.frames(time).unwrap();
            for (j, bone) in body.skeleton.names.iter().enumerate() {
                let Some(there) = clip.find(bone) else {
                    continue;
                };
                let turned = rotation_log(expected[there].rotation.transpose() * found[j].rotation);
                assert!(turned.length() < 1e-6, "{name} {bone}: {turned}");
            }
        }
    }
}

/// WebXR's hands on the WebXR hand, and mirrored on the sample's right hand: joints lie where the tracker
/// has them, but for the lengths of bones.
#[test]
fn tracked_hands_pose_hands() {
    for (name, mirror) in [("relaxed", true), ("pinch", true)] {
        let Some(path) = asset(&format!("hand-poses/{name}.js")) else {
            continue;
        };
        let model = supple_samples::hand().unwrap().model;
        let skeleton = model.skeleton(&[]);
        let motion = TrackedMotion {
            mirror,
            ..TrackedMotion::of_file(&path)
        };
        let mut playback = Playback::open(&motion, &skeleton, UpAxis::Y, UpAxis::Z).unwrap();
        assert_eq!(playback.retarget().map().pairs.len(), 16, "{name}");
        playback.stand_at(&skeleton.bind_pose());
        let frames = playback.frames(0.0).unwrap();
        // Fingertips' side: in a pinch thumb and index meet; a right hand's thumb stays on its +y side.
        let end = |bone: &str| -> DVec3 {
            let j = skeleton.find(bone).unwrap();
            let parent = skeleton.parents[j].unwrap() as usize;
            frames[j].transform(0.8 * (skeleton.joints[j] - skeleton.joints[parent]))
        };
        let gap = (end("thumb3") - end("index3")).length();
        if name == "pinch" {
            assert!(gap < 0.035, "{gap}");
        } else {
            assert!(gap > 0.035, "{gap}");
        }
        let proper = |f: &Frame| {
            (f.rotation.transpose() * f.rotation - DMat3::IDENTITY)
                .determinant()
                .abs()
        };
        assert!(frames.iter().all(|f| proper(f) < 1e-9));
    }
}
