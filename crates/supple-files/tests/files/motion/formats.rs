//! BVH, AMASS and hand poses: hand-computed places, and nothing broken gets through.

use std::io::Write;
use std::path::{Path, PathBuf};
use supple::Error;
use supple::glam::{DQuat, DVec3};
use supple::internal::math::{Random, rotation_exp, rotation_log};
use supple::model::UpAxis;
use supple_files::{
    BvhOptions, ClipOptions, ClipPlayer, PoseOptions, PoseParser, PosePlayer, Unit, bvh_text,
    clip_as_poses, parse_bvh, parse_pose, pose_header_line, pose_line, read_amass,
};
use supple_samples::hand::grasp;
use supple_samples::walk;

/// Two joints with different orders of rotation, a position channel on the inner one, names with spaces,
/// `Frames:` without a space, Windows line ends.
const BVH: &str = "HIERARCHY\r\nROOT my hips\r\n{\r\n OFFSET 1 2 3\r\n CHANNELS 6 Xposition Yposition \
Zposition Zrotation Xrotation Yrotation\r\n JOINT knee {\r\n OFFSET 0 -10 0\r\n CHANNELS 4 Yposition \
Xrotation Yrotation Zrotation\r\n End Site\r\n {\r\n OFFSET 0 -8 0\r\n }\r\n }\r\n}\r\nMOTION\r\nFrames:2\r\n\
Frame Time: 0.5\r\n1 2 3 0 0 0 -10 0 0 0\r\n4 5 6 90 90 0 -11 90 0 90\r\n";

fn bvh(text: &str) -> Result<supple_files::MotionClip, Error> {
    let options = BvhOptions {
        unit: Some(Unit::Name("cm".into())),
        ..BvhOptions::default()
    };
    parse_bvh(text, Path::new("clip.bvh"), &options)
}

#[test]
fn a_bvh_is_what_it_says_by_hand() {
    let clip = bvh(BVH).unwrap();
    assert_eq!(clip.bones, ["my hips", "knee"]);
    assert_eq!((clip.frame_time, clip.frames.len()), (0.5, 2));
    let near = |found: DVec3, centimetres: [f64; 3]| {
        let miss = found - 0.01 * DVec3::from(centimetres);
        assert!(miss.length() < 1e-15, "{found} for {centimetres:?}");
    };
    let rest = clip.rest_joints.as_ref().unwrap();
    near(rest[0], [1.0, 2.0, 3.0]);
    near(rest[1], [1.0, -8.0, 3.0]);
    let frames = clip.world_frames(&clip.frames[0]);
    near(frames[0].position, [1.0, 2.0, 3.0]);
    near(frames[1].position, [1.0, -8.0, 3.0]);
    // Second frame: the hips turn by Rz(90°) Rx(90°): x → y, y → z, z → x. The knee is 11 below them:
    // −11 y → −11 z.
    let frames = clip.world_frames(&clip.frames[1]);
    near(frames[0].position, [4.0, 5.0, 6.0]);
    near(frames[1].position, [4.0, 5.0, -5.0]);
    // The knee turns by Rx(90°) Rz(90°): x → y → z, and the hips take that z to x.
    let axis = |j: usize, v: DVec3| frames[j].rotation * v;
    assert!((axis(0, DVec3::X) - DVec3::Y).length() < 1e-15);
    assert!((axis(0, DVec3::Y) - DVec3::Z).length() < 1e-15);
    assert!((axis(1, DVec3::X) - DVec3::X).length() < 1e-15);
    // y → −x → −x → −y.
    assert!((axis(1, DVec3::Y) + DVec3::Y).length() < 1e-15);
}

#[test]
fn a_broken_bvh_names_its_line() {
    let wrong = |from: &str, to: &str, line: usize, hint: &str| {
        let text = BVH.replacen(from, to, 1);
        assert_ne!(text, BVH, "{from}");
        let error = bvh(&text).unwrap_err().to_string();
        let place = format!("clip.bvh: line {line}: ");
        assert!(error.starts_with(&place) && error.contains(hint), "{error}");
    };
    wrong("HIERARCHY", "", 2, "begins with HIERARCHY");
    wrong("OFFSET 1 2 3", "OFFSET 1 2", 4, "\"\" is no number");
    wrong("OFFSET 1 2 3", "OFFSET 1 2 nan", 4, "\"nan\" is no number");
    wrong(
        "CHANNELS 6",
        "CHANNELS 5",
        5,
        "5 channels announced, 6 named",
    );
    wrong("Xrotation", "Wrotation", 5, "\"Wrotation\" is no channel");
    wrong("knee {", "knee { {", 6, "{ follows");
    wrong(
        "Frames:2",
        "Frames:3",
        19,
        "3 frames of 10 numbers are announced, 20",
    );
    wrong("Frames:2", "Frames:99999999999999999999", 19, "announced");
    wrong("Frames:2", "Frames:-1", 19, "announced");
    wrong("Frame Time: 0.5", "Frame Time: 0", 17, "positive");
    wrong("Frame Time", "Time", 17, "`Frame Time:` is expected");
    wrong("4 5 6", "4 5 1e999", 19, "no number");
    wrong("MOTION", "", 16, "is none of");
}

/// Cut anywhere, or with any byte changed, a file is read or refused, and nothing panics.
#[test]
fn damaged_files_are_read_or_refused() {
    let mut random = Random::new(11);
    let pose =
        "export const p = {bones: {a: {position: [1, 2, 3]}, 'b': {rotation: [0, 0, 0, 1]}}};";
    for text in [BVH, pose] {
        for at in 0..text.len() {
            let cut = &text[..at];
            let mut changed = text.as_bytes().to_vec();
            changed[at] = random.index(128) as u8;
            let changed = String::from_utf8_lossy(&changed).into_owned();
            for damaged in [cut, &changed] {
                let _ = bvh(damaged);
                let _ = parse_pose(damaged, Path::new("pose.js"));
            }
        }
    }
}

#[test]
fn what_is_written_as_bvh_is_read() {
    let clip = walk();
    let back = parse_bvh(
        &bvh_text(&clip),
        Path::new("walk.bvh"),
        &BvhOptions::default(),
    )
    .unwrap();
    assert_eq!(back.frames.len(), clip.frames.len());
    for (frame, read) in clip.frames.iter().zip(&back.frames) {
        let (frames, read) = (clip.world_frames(frame), back.world_frames(read));
        for (j, name) in clip.bones.iter().enumerate() {
            let there = back.find(name).unwrap();
            // Four places of a centimetre and of a degree, over a dozen joints.
            let miss = (frames[j].position - read[there].position).length();
            assert!(miss < 2e-5, "{name} misses by {miss} m");
        }
    }
}

#[test]
fn the_committed_walk_is_the_generator_s() {
    let committed = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../assets/motions/walk.bvh"
    ))
    .unwrap();
    assert!(
        committed == bvh_text(&walk()),
        "write it anew: supple sample walk -o assets/motions"
    );
}

#[test]
fn the_committed_grasp_is_the_generator_s() {
    let committed = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../assets/motions/grasp.jsonl"
    ))
    .unwrap();
    let lines: String = grasp().iter().map(pose_line).collect();
    assert!(
        committed == lines,
        "write it anew: supple sample grasp -o assets/motions"
    );
}

/// Bytes of a `.npy` file of f64.
fn npy(shape: &[usize], values: &[f64]) -> Vec<u8> {
    let sizes: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({sizes}), }}");
    header += &" ".repeat((64 - (11 + header.len()) % 64) % 64);
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

pub fn npz(folder: &Path, arrays: &[(&str, &[usize], &[f64])]) -> PathBuf {
    let path = folder.join("motion.npz");
    let mut zip = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
    for (name, shape, values) in arrays {
        let options = zip::write::SimpleFileOptions::default();
        zip.start_file(format!("{name}.npy"), options).unwrap();
        zip.write_all(&npy(shape, values)).unwrap();
    }
    zip.finish().unwrap();
    path
}

#[test]
fn amass_is_read_in_every_width_and_spelling() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random::new(3);
    for (width, bones, rate) in [
        (72, 24, "mocap_framerate"),
        (66, 22, "mocap_frame_rate"),
        (156, 52, "mocap_framerate"),
        (165, 55, "mocap_frame_rate"),
        (48, 16, "mocap_framerate"),
    ] {
        let poses: Vec<f64> = (0..2 * width).map(|_| random.uniform(-1.0, 1.0)).collect();
        let trans = [0.0, 0.5, 1.0, 0.1, 0.6, 1.1];
        let path = npz(
            folder.path(),
            &[
                ("poses", &[2, width], &poses),
                ("trans", &[2, 3], &trans),
                (rate, &[], &[120.0]),
            ],
        );
        let clip = read_amass(&path).unwrap();
        assert_eq!((clip.bones.len(), clip.frames.len()), (bones, 2));
        assert_eq!((clip.rest_up, clip.world_up), (UpAxis::Y, UpAxis::Z));
        assert!((clip.frame_time - 1.0 / 120.0).abs() < 1e-15);
        assert_eq!(clip.frames[1].translations, [DVec3::new(0.1, 0.6, 1.1)]);
        for j in 0..bones {
            let v = DVec3::from_slice(&poses[width + 3 * j..]);
            let expected = DQuat::from_mat3(&rotation_exp(v));
            assert!(clip.frames[1].rotations[j].angle_between(expected) < 1e-7);
        }
        for (name, parent) in [
            ("left_index1", "left_wrist"),
            ("right_thumb3", "right_thumb2"),
            ("jaw", "head"),
            ("right_foot", "right_ankle"),
            ("pinky1", "wrist"),
        ] {
            if let Some(j) = clip.find(name) {
                assert_eq!(clip.bones[clip.parents[j].unwrap() as usize], parent);
            }
        }
    }
}

#[test]
fn a_broken_amass_names_its_key() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = |arrays: &[(&str, &[usize], &[f64])], field: &str, hint: &str| {
        let error = read_amass(npz(folder.path(), arrays)).unwrap_err();
        let text = error.to_string();
        assert!(
            matches!(&error, Error::Format { field: f, .. } if f == field),
            "{text}"
        );
        assert!(text.contains(hint), "{text}");
    };
    let (poses, trans) = ([0.0; 72], [0.0; 3]);
    let rate: (&str, &[usize], &[f64]) = ("mocap_framerate", &[], &[60.0]);
    wrong(&[("trans", &[1, 3], &trans), rate], "poses", "missing");
    wrong(&[("poses", &[1, 72], &poses), rate], "trans", "missing");
    wrong(
        &[("poses", &[1, 72], &poses), ("trans", &[1, 3], &trans)],
        "mocap_framerate",
        "missing",
    );
    wrong(
        &[
            ("poses", &[1, 72], &poses),
            ("trans", &[1, 3], &trans),
            ("mocap_framerate", &[], &[0.0]),
        ],
        "mocap_framerate",
        "missing",
    );
    wrong(
        &[
            ("poses", &[2, 36], &poses),
            ("trans", &[1, 3], &trans),
            rate,
        ],
        "poses",
        "36 numbers",
    );
    wrong(
        &[
            ("poses", &[1, 72], &poses),
            ("trans", &[3, 1], &trans),
            rate,
        ],
        "trans",
        "shape",
    );
    wrong(
        &[("poses", &[0, 72], &[]), ("trans", &[0, 3], &[]), rate],
        "motion.frames",
        "none",
    );
    let mut bad = poses;
    bad[5] = f64::NAN;
    wrong(
        &[("poses", &[1, 72], &bad), ("trans", &[1, 3], &trans), rate],
        "poses",
        "element 5",
    );
}

/// A clip that goes out as a stream and comes back says the same of an avatar.
#[test]
fn a_stream_of_a_clip_is_the_clip() {
    let clip = walk();
    let (header, poses) = clip_as_poses(&clip).unwrap();
    let mut parser = PoseParser::new("walk.jsonl");
    parser.push(pose_header_line(&header).as_bytes()).unwrap();
    for pose in &poses {
        parser.push(pose_line(pose).as_bytes()).unwrap();
    }
    assert_eq!(parser.header().rest.len(), clip.bones.len());
    let skeleton = super::retarget::smpl();
    let first = parser.next_pose().unwrap();
    let mut player = PosePlayer::new(header, &first, &skeleton, &PoseOptions::default()).unwrap();
    let mut direct = ClipPlayer::new(clip, &skeleton, &ClipOptions::default()).unwrap();
    let standing = direct.frames(0.0);
    player.stand_at(&standing);
    direct.stand_at(&standing);
    for k in 0..50 {
        let time = 0.037 * f64::from(k);
        let streamed = player.frames(time, &mut || Ok(parser.next_pose())).unwrap();
        for (a, b) in streamed.iter().zip(direct.frames(time)) {
            let turned = rotation_log(a.rotation * b.rotation.transpose()).length();
            // Between frames one blends world rotations, the other those to the parent.
            assert!(turned < 0.02, "{turned}");
            assert!((a.position.truncate() - b.position.truncate()).length() < 2e-3);
        }
    }
}
