//! Which bone is placed where the motion has it, and what of a clip no avatar follows.

use super::retarget::{player, smpl};
use supple::glam::DVec3;
use supple::model::Skeleton;
use supple_files::{ClipOptions, MotionClip, read_character, read_gltf_motions};
use supple_samples::walk;

/// `skeleton` under a root on the floor.
fn with_floor_root(skeleton: &Skeleton, name: &str) -> Skeleton {
    let above = |p: &Option<u32>| Some(p.map_or(0, |p| p + 1));
    Skeleton {
        names: [&[name.to_string()], &skeleton.names[..]].concat(),
        parents: std::iter::once(None)
            .chain(skeleton.parents.iter().map(above))
            .collect(),
        joints: [&[-0.9 * DVec3::Y], &skeleton.joints[..]].concat(),
        aliases: Vec::new(),
        limits: Vec::new(),
    }
}

/// `clip` on that skeleton: the root stays, the pelvis moves against it.
fn under_floor_root(clip: &MotionClip, name: &str) -> MotionClip {
    let own = Skeleton {
        joints: clip.rest_joints.clone().unwrap(),
        ..smpl()
    };
    let rooted = with_floor_root(&own, name);
    let mut under = MotionClip {
        bones: rooted.names,
        parents: rooted.parents,
        rest_joints: Some(rooted.joints),
        translated: clip.translated.iter().map(|j| j + 1).collect(),
        ..clip.clone()
    };
    for frame in &mut under.frames {
        frame.rotations.insert(0, Default::default());
    }
    under
}

/// The way of each joint over the walk is that of a skeleton whose root is the pelvis, whatever stands above it.
#[test]
fn a_pelvis_below_a_floor_root_goes_where_the_motion_has_it() {
    let plain = player(walk(), &smpl(), &ClipOptions::default());
    for name in ["root", "Reference", "Armature", "pelvis_root"] {
        let avatar = with_floor_root(&smpl(), name);
        for clip in [under_floor_root(&walk(), name), walk()] {
            let rooted = player(clip, &avatar, &ClipOptions::default());
            assert_eq!(rooted.retarget().root(), Some(1), "{name}");
            for k in 0..=20 {
                let time = 0.1 * f64::from(k);
                let way = |frames: Vec<supple::model::Frame>, first: &DVec3, from: usize| {
                    let joints = frames.into_iter().skip(from);
                    joints.map(|f| f.position - *first).collect::<Vec<_>>()
                };
                let (a, b) = (
                    plain.frames(0.0)[0].position,
                    rooted.frames(0.0)[1].position,
                );
                let (a, b) = (
                    way(plain.frames(time), &a, 0),
                    way(rooted.frames(time), &b, 1),
                );
                for (a, b) in a.iter().zip(&b) {
                    assert!((*a - *b).length() < 1e-9, "{name}: {a} for {b}");
                }
            }
        }
    }
}

/// Without a bone called hips it is what the legs hang on.
#[test]
fn a_pelvis_of_another_name_is_found_by_its_legs() {
    let named = |names: &mut [String]| names[1] = "Bip001".into();
    let (mut clip, mut avatar) = (
        under_floor_root(&walk(), "floor"),
        with_floor_root(&smpl(), "floor"),
    );
    named(&mut clip.bones);
    named(&mut avatar.names);
    let player = player(clip, &avatar, &ClipOptions::default());
    assert_eq!(player.retarget().root(), Some(1));
    assert_eq!(player.clip().notes, [""; 0], "the pelvis' way is followed");
}

#[test]
fn a_joint_that_slides_is_told() {
    let slid = |bone: &str, by: f64| {
        let mut clip = walk();
        let j = clip.find(bone).unwrap();
        clip.translated.push(j as u32);
        for (k, frame) in clip.frames.iter_mut().enumerate() {
            frame
                .translations
                .push(by * f64::from(u8::from(k == 9)) * DVec3::X);
        }
        clip
    };
    let notes = |clip: MotionClip, avatar: &Skeleton| {
        player(clip, avatar, &ClipOptions::default())
            .clip()
            .notes
            .clone()
    };
    let said = notes(slid("spine2", 0.07), &smpl()).concat();
    for word in ["\"walk\"", "spine2", "70 mm"] {
        assert!(said.contains(word), "{said}");
    }
    assert_eq!(notes(slid("spine2", 0.001), &smpl()), [""; 0]);
    // What moves no bone of the avatar is not missed.
    let mut headless = smpl();
    headless.names[15] = "antenna".into();
    assert_eq!(notes(slid("head", 0.07), &headless), [""; 0]);
}

/// A squat whose hips are the root, and one under a root on the floor; and a clip that slides a chest.
#[test]
fn recorded_roots_and_slides() {
    let folder = std::path::Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/cases"
    ));
    if !folder.exists() {
        eprintln!("skipped: {} is not there", folder.display());
        return;
    }
    let own = |name: &str| {
        let path = folder.join(name);
        let skeleton = read_character(&path, &Default::default())
            .unwrap()
            .body
            .skeleton;
        let clip = read_gltf_motions(&path).unwrap().remove(0);
        let hips = skeleton.find("hips").unwrap();
        (player(clip, &skeleton, &ClipOptions::default()), hips)
    };
    let travel = |name: &str| {
        let (player, hips) = own(name);
        let heights = (0..=50).map(|k| {
            let time = f64::from(k) / 50.0 * player.clip().duration();
            player.frames(time)[hips].position.z
        });
        let ends = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| {
            (z.min(low), z.max(high))
        });
        ends.1 - ends.0
    };
    let (plain, floor) = (
        travel("hips_root_squat.glb"),
        travel("floor_root_squat.glb"),
    );
    eprintln!("hips travel {plain} m, {floor} m");
    assert!(
        plain > 0.15 && (plain - floor).abs() < 1e-6,
        "{plain}, {floor}"
    );
    let said = own("stretch_spine.glb").0.clip().notes.concat();
    assert!(said.contains("chest by 70 mm"), "{said}");
}
