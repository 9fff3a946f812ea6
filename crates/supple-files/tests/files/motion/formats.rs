//! BVH, AMASS and hand poses: hand-computed places, and nothing broken gets through.

use std::path::Path;
use supple::Error;
use supple::glam::DVec3;
use supple::internal::math::{Random, rotation_log};
use supple_files::{
    BvhOptions, ClipOptions, ClipPlayer, PoseOptions, PoseParser, PosePlayer, Unit, bvh_text,
    clip_as_poses, parse_bvh, parse_pose, pose_header_line, pose_line,
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
    wrong("Frames:2", "Frames:-1", 16, "whole number");
    wrong("Frames:2", "Frames:1.5", 16, "whole number");
    wrong(
        " 0 90\r\n",
        "\r\n",
        19,
        "2 frames of 10 numbers are announced, 18",
    );
    wrong(" 0 90\r\n", "\r\n", 19, "1 frames and 8 numbers of another");
    wrong("Frame Time: 0.5", "Frame Time: 0", 17, "positive");
    wrong("Frame Time", "Time", 17, "`Frame Time:` is expected");
    wrong("4 5 6", "4 5 1e999", 19, "no number");
    wrong("MOTION", "", 16, "is none of");
}

/// Whole lines count, whatever the file announces; that it differs is said.
#[test]
fn a_bvh_has_the_frames_that_are_there() {
    assert_eq!(bvh(BVH).unwrap().notes, [""; 0]);
    for announced in ["1", "3", "0", "4000000000"] {
        let clip = bvh(&BVH.replacen("Frames:2", &format!("Frames:{announced}"), 1)).unwrap();
        assert_eq!(clip.frames, bvh(BVH).unwrap().frames);
        let said = clip.notes.concat();
        assert!(
            said.contains(announced) && said.contains("2 are there"),
            "{said}"
        );
    }
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

/// A clip that goes out as a stream and comes back says the same of an avatar.
#[test]
fn a_stream_of_a_clip_is_the_clip() {
    let clip = walk();
    let frame_time = clip.frame_time;
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
        // In between a clip knows what comes and curves, a stream goes along the chord.
        let time = frame_time * f64::from(k);
        let streamed = player.frames(time, &mut || Ok(parser.next_pose())).unwrap();
        for (a, b) in streamed.iter().zip(direct.frames(time)) {
            let turned = rotation_log(a.rotation * b.rotation.transpose()).length();
            assert!(turned < 1e-4, "{turned}");
            assert!((a.position.truncate() - b.position.truncate()).length() < 1e-4);
        }
    }
}
