//! One skeleton's motion on another.

use supple::glam::{DMat3, DQuat, DVec3};
use supple::internal::math::{Random, rotation_exp};
use supple::model::{Frame, Skeleton, UpAxis};
use supple_files::{
    Align, BonePose, BonePoses, ClipOptions, ClipPlayer, MotionClip, MotionFrame, Origin,
    PoseHeader, PoseOptions, PosePlayer, RetargetOptions, mirrored_clip,
};
use supple_samples::{hand, walk};

/// The walk's own skeleton.
pub fn smpl() -> Skeleton {
    let clip = walk();
    Skeleton {
        names: clip.bones,
        parents: clip.parents,
        joints: clip.rest_joints.unwrap(),
        aliases: Vec::new(),
        limits: Vec::new(),
    }
}

/// `skeleton` with other names, `scale` times as large, arms turned down by `angle`, z up and facing −y.
fn a_pose(scale: f64, angle: f64) -> Skeleton {
    let mut skeleton = smpl();
    let mut local = vec![DMat3::IDENTITY; skeleton.len()];
    local[16] = rotation_exp(DVec3::Z * -angle);
    local[17] = rotation_exp(DVec3::Z * angle);
    let posed = skeleton.forward_kinematics(&local, skeleton.joints[0]);
    let up = rotation_exp(DVec3::X * std::f64::consts::FRAC_PI_2);
    skeleton.joints = posed.iter().map(|f| scale * (up * f.position)).collect();
    let unreal = [
        "pelvis",
        "thigh_l",
        "thigh_r",
        "spine_01",
        "calf_l",
        "calf_r",
        "spine_02",
        "foot_l",
        "foot_r",
        "spine_03",
        "ball_l",
        "ball_r",
        "neck_01",
        "clavicle_l",
        "clavicle_r",
        "head",
        "upperarm_l",
        "upperarm_r",
        "lowerarm_l",
        "lowerarm_r",
        "hand_l",
        "hand_r",
        "tip_l",
        "tip_r",
    ];
    skeleton.names = unreal.map(Into::into).to_vec();
    skeleton
}

pub fn player(clip: MotionClip, skeleton: &Skeleton, options: &ClipOptions) -> ClipPlayer {
    let mut player = ClipPlayer::new(clip, skeleton, options).unwrap();
    let mut local = vec![DMat3::IDENTITY; skeleton.len()];
    local[0] = player.retarget().standing();
    let standing = skeleton.forward_kinematics(&local, skeleton.joints[0]);
    player.stand_at(&standing);
    player
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

/// An A pose that is otherwise the motion's own skeleton, larger and turned: driven, its joints are where
/// the motion has them, larger and turned.
#[test]
fn a_t_pose_s_motion_drives_an_a_pose_exactly() {
    let (clip, avatar) = (walk(), a_pose(1.3, 0.8));
    let options = ClipOptions {
        origin: Origin::Motion,
        ..ClipOptions::default()
    };
    let player = player(clip.clone(), &avatar, &options);
    assert!((player.retarget().scale() - 1.3).abs() < 1e-12);
    // z up is y up turned by 90° about x.
    let up = rotation_exp(DVec3::X * std::f64::consts::FRAC_PI_2);
    for k in [0, 7, 22, 41] {
        let expected = clip.world_frames(&clip.frames[k]);
        let found = player.frames(k as f64 * clip.frame_time);
        let miss = expected.iter().zip(&found).take(22);
        let miss = largest(miss.map(|(e, f)| (1.3 * (up * e.position) - f.position).length()));
        assert!(miss < 1e-9, "frame {k}: {miss} m");
    }
    // Without alignment the arms are turned by the A pose too.
    let plain = ClipOptions {
        retarget: RetargetOptions {
            align: Align::None,
            ..RetargetOptions::default()
        },
        ..options
    };
    let plain = self::player(clip, &avatar, &plain).frames(0.0);
    assert!((plain[20].position - player.frames(0.0)[20].position).length() > 0.2);
}

/// A skeleton's own clip gives its own joints, and a rest frame is where the bind pose stands.
#[test]
fn a_rest_frame_is_the_bind_pose() {
    let (mut clip, avatar) = (walk(), smpl());
    clip.frames.swap(0, 9);
    let options = ClipOptions {
        rest_frame: Some(9),
        ..ClipOptions::default()
    };
    let player = player(clip.clone(), &avatar, &options);
    let up = rotation_exp(DVec3::X * std::f64::consts::FRAC_PI_2);
    let bound = player.frames(9.0 * clip.frame_time);
    let turned = largest(bound.iter().map(|f| {
        let defect = f.rotation * up.transpose() - bound[0].rotation * up.transpose();
        largest(defect.to_cols_array().into_iter().map(f64::abs))
    }));
    assert!(turned < 1e-12, "all bones are turned alike: {turned}");
}

#[test]
fn it_begins_where_the_avatar_stands_with_its_feet_on_the_ground() {
    let (clip, avatar) = (walk(), a_pose(1.0, 0.8));
    let mut player = ClipPlayer::new(clip.clone(), &avatar, &ClipOptions::default()).unwrap();
    let mut local = vec![DMat3::IDENTITY; avatar.len()];
    local[0] = rotation_exp(DVec3::Z * 1.1) * player.retarget().standing();
    let standing = avatar.forward_kinematics(&local, DVec3::new(3.0, -2.0, 5.0));
    player.stand_at(&standing);
    let first = player.frames(0.0);
    let shift = first[0].position - standing[0].position;
    assert!(shift.truncate().length() < 1e-9, "{shift}");
    // It walks where it faced: −y turned by 1.1 rad.
    let way = player.frames(2.0)[0].position - first[0].position;
    let ahead = rotation_exp(DVec3::Z * 1.1) * -DVec3::Y;
    // The pelvis is turned by 5° in the first pose, and so is the way.
    assert!((way - 2.4 * ahead).length() < 2.4 * 0.1, "{way}");
    let lowest = |frames: &[Frame]| {
        let feet = [7, 8, 10, 11].map(|j: usize| frames[j].position.z);
        feet.into_iter().fold(f64::INFINITY, f64::min)
    };
    let times = (0..=120).map(|k| lowest(&player.frames(f64::from(k) / 60.0)));
    let ground = times.fold(f64::INFINITY, f64::min);
    assert!((ground - lowest(&standing)).abs() < 1e-3);
}

#[test]
fn a_loop_goes_on_from_where_it_ended() {
    let avatar = smpl();
    let options = ClipOptions {
        repeat: true,
        ..ClipOptions::default()
    };
    let walking = player(walk(), &avatar, &options);
    let at = |t: f64| walking.frames(t)[0].position;
    assert!(((at(6.3) - at(0.3)) - 3.0 * (at(2.3) - at(0.3))).length() < 1e-9);
    // A clip cut off in mid-stride fades: no joint leaps.
    let mut cut = walk();
    cut.frames.truncate(40);
    let cut = player(cut, &avatar, &options);
    let step = 1.0 / 240.0;
    let mut before = cut.frames(0.0);
    for k in 1..1200 {
        let now = cut.frames(step * f64::from(k));
        let leap = largest(
            now.iter()
                .zip(&before)
                .map(|(a, b)| (a.position - b.position).length()),
        );
        // 8 m/s is faster than any joint of the walk.
        assert!(leap < 8.0 * step, "{leap} m at {}", step * f64::from(k));
        before = now;
    }
}

/// AMASS's poses come without a rest pose: on SMPL's own skeleton they are taken as they are.
#[test]
fn smpl_poses_are_exact_on_smpl() {
    let mut random = Random::new(5);
    let avatar = smpl();
    let mut clip = walk();
    clip.rest_joints = None;
    clip.world_up = UpAxis::Z;
    clip.frames = vec![MotionFrame {
        translations: vec![DVec3::new(0.3, 0.2, 0.9)],
        rotations: (0..24)
            .map(|_| DQuat::from_mat3(&random.rotation(1.0)))
            .collect(),
    }];
    let options = ClipOptions {
        origin: Origin::Motion,
        ..ClipOptions::default()
    };
    let found = player(clip.clone(), &avatar, &options).frames(0.0);
    let local: Vec<DMat3> = clip.frames[0]
        .rotations
        .iter()
        .map(|q| DMat3::from_quat(*q))
        .collect();
    let expected = avatar.forward_kinematics(&local, clip.frames[0].translations[0]);
    for (e, f) in expected.iter().zip(&found) {
        assert!((e.position - f.position).length() < 1e-12);
        assert!((e.rotation.y_axis - f.rotation.y_axis).length() < 1e-12);
    }
}

#[test]
fn a_mirrored_walk_leads_with_the_other_leg() {
    let clip = walk();
    let mirrored = mirrored_clip(&clip);
    // Half a stride on, the walk is its own mirror image.
    let half = clip.sample(0.5);
    for (a, b) in half.rotations.iter().zip(&mirrored.frames[0].rotations) {
        assert!(
            a.angle_between(*b) < 0.02,
            "{}",
            a.angle_between(*b).to_degrees()
        );
    }
}

/// Places of joints alone, as a hand tracker gives them, bring the sample hand to its pose.
#[test]
fn a_hand_is_posed_from_places() {
    let model = hand().unwrap().model;
    let skeleton = model.skeleton(&[]);
    let mut random = Random::new(2);
    let mut worst = 0.0f64;
    for _ in 0..5 {
        let mut local = vec![DMat3::IDENTITY; skeleton.len()];
        local[0] = random.rotation(1.0);
        for (j, r) in local.iter_mut().enumerate().skip(1) {
            // About the finger's hinge: y for a right hand with fingers along x.
            let bend = random.uniform(0.0, 1.0);
            *r = if skeleton.names[j].starts_with("thumb") {
                DMat3::IDENTITY
            } else {
                rotation_exp(DVec3::Y * bend)
            };
        }
        let frames = skeleton.forward_kinematics(&local, DVec3::new(0.2, -0.1, 1.0));
        let bones = (skeleton.names.iter().zip(&frames)).map(|(name, f)| {
            let position = Some(f.position);
            (
                name.clone(),
                BonePose {
                    rotation: None,
                    position,
                },
            )
        });
        let poses = BonePoses {
            time: 3.0,
            bones: bones.collect(),
        };
        let header = PoseHeader::default();
        let options = PoseOptions::default();
        let mut player = PosePlayer::new(header, &poses, &skeleton, &options).unwrap();
        player.stand_at(&skeleton.bind_pose());
        let found = player.frames(0.0, &mut || Ok(None)).unwrap();
        for (e, f) in frames.iter().zip(&found) {
            worst = worst.max((e.position - f.position).length());
        }
    }
    assert!(worst < 1e-9, "{worst} m");
}

/// A stream's rest pose, in its own axes: rotations are away from it.
#[test]
fn a_stream_with_a_rest_pose_turns_as_its_source_does() {
    let skeleton = smpl();
    let mut random = Random::new(9);
    let up = rotation_exp(DVec3::X * std::f64::consts::FRAC_PI_2);
    // The source: the same skeleton, whose bones have axes of their own at rest; a y-up world.
    let axes: Vec<DMat3> = (0..skeleton.len()).map(|_| random.rotation(3.0)).collect();
    let pose = |j: usize, rotation: DMat3, position: DVec3| BonePose {
        rotation: Some(DQuat::from_mat3(&(rotation * axes[j]))),
        position: Some(position),
    };
    let named = |poses: Vec<BonePose>| skeleton.names.iter().cloned().zip(poses).collect();
    let rest = (0..skeleton.len()).map(|j| pose(j, DMat3::IDENTITY, skeleton.joints[j]));
    let header = PoseHeader {
        up: Some(UpAxis::Y),
        rest: named(rest.collect()),
    };
    let local: Vec<DMat3> = (0..skeleton.len()).map(|_| random.rotation(0.5)).collect();
    let frames = skeleton.forward_kinematics(&local, DVec3::new(0.5, 1.0, 0.2));
    let bones = frames
        .iter()
        .enumerate()
        .map(|(j, f)| pose(j, f.rotation, f.position));
    let poses = BonePoses {
        time: 0.0,
        bones: named(bones.collect()),
    };
    let options = PoseOptions {
        origin: Some(Origin::Motion),
        ..PoseOptions::default()
    };
    let mut player = PosePlayer::new(header, &poses, &skeleton, &options).unwrap();
    let found = player.frames(0.0, &mut || Ok(None)).unwrap();
    for (e, f) in frames.iter().zip(&found) {
        assert!((up * e.position - f.position).length() < 1e-9);
        assert!((up * e.rotation.x_axis - f.rotation.x_axis).length() < 1e-6);
    }
}

/// Between two poses of a stream, after its end, and where a bone is lost.
#[test]
fn a_stream_is_interpolated_and_held() {
    let skeleton = smpl();
    let pose = |time: f64, bones: &[(&str, f64)]| BonePoses {
        time,
        bones: (bones.iter())
            .map(|(name, angle)| {
                let bone = BonePose {
                    rotation: Some(DQuat::from_rotation_x(*angle)),
                    position: None,
                };
                (name.to_string(), bone)
            })
            .collect(),
    };
    let first = pose(10.0, &[("head", 0.0), ("neck", 0.0)]);
    let mut later = vec![
        pose(12.0, &[("head", 1.0)]),
        pose(11.0, &[("head", 0.4), ("neck", 0.2)]),
    ];
    let options = PoseOptions::default();
    let header = PoseHeader::default();
    let mut player = PosePlayer::new(header.clone(), &first, &skeleton, &options).unwrap();
    player.stand_at(&skeleton.bind_pose());
    let mut angles = |time: f64| {
        let frames = player.frames(time, &mut || Ok(later.pop())).unwrap();
        let angle = |j: usize| frames[j].rotation.y_axis.z.asin();
        (angle(15), angle(12), frames[0].position)
    };
    let near = |found: (f64, f64, DVec3), head: f64, neck: f64| {
        assert!(
            (found.0 - head).abs() < 1e-9 && (found.1 - neck).abs() < 1e-9,
            "{found:?}"
        );
        assert_eq!(found.2, skeleton.joints[0]);
    };
    near(angles(0.0), 0.0, 0.0);
    near(angles(0.5), 0.2, 0.1);
    near(angles(1.5), 0.7, 0.2);
    near(angles(99.0), 1.0, 0.2);
    let mut stranger = Some(pose(11.0, &[("tail", 1.0)]));
    let mut player = PosePlayer::new(header, &first, &skeleton, &options).unwrap();
    let error = player.frames(0.5, &mut || Ok(stranger.take())).unwrap_err();
    assert!(error.to_string().contains("\"tail\" is new"), "{error}");
}
