//! Motions of the AMASS archive, `.npz`: SMPL's, SMPL-H's or SMPL-X's pose parameters.
//!
//! | key | shape | |
//! |---|---|---|
//! | `poses` | frames × 3 joints | rotation vectors relative to the parent, rad |
//! | `trans` | frames × 3 | of the root, m; z up |
//! | `mocap_framerate` or `mocap_frame_rate` | one number | frames a second |
//!
//! Mahmood et al., *AMASS: Archive of Motion Capture as Surface Shapes*, 2019. The root's joint is at
//! J₀ + trans; `betas` and `gender` shape the body and are not needed to move one.

use crate::motion::smpl::{BODY as SMPL_BODY, FINGERS};
use crate::motion::{MotionClip, MotionFrame};
use crate::{file, npz};
use glam::{DQuat, DVec3};
use std::path::Path;
use supple::Result;
use supple::model::UpAxis;

/// Reads the motion at `path`.
///
/// # Errors
/// [`supple::Error::Io`]; [`supple::Error::Format`] with the key, what was expected and what was found.
pub fn read_amass(path: impl AsRef<Path>) -> Result<MotionClip> {
    let path = path.as_ref();
    parse_amass(&file::read_bytes(path)?, path)
}

/// Reads a motion from a file's `bytes`; `path` names it in errors. See [`read_amass`].
pub fn parse_amass(bytes: &[u8], path: &Path) -> Result<MotionClip> {
    const RATES: [&str; 2] = ["mocap_framerate", "mocap_frame_rate"];
    let archive = npz::parse(bytes, path, &["poses", "trans", RATES[0], RATES[1]])?;
    let poses = archive.expect("poses", &[None, None])?;
    let (count, width) = (poses.shape[0], poses.shape[1]);
    let (bones, parents) = tree(width).ok_or_else(|| {
        let problem = format!(
            "{width} numbers a frame; SMPL has 72, its body alone 66, SMPL-H 156, SMPL-X 165, MANO 48"
        );
        archive.broken("poses", problem)
    })?;
    let trans = archive.expect("trans", &[Some(count), Some(3)])?;
    let rate = match archive.get(RATES[0])? {
        Some(rate) => Some(rate),
        None => archive.get(RATES[1])?,
    };
    let rate = rate.and_then(|r| r.numbers.first().copied());
    let rate = rate.filter(|r| *r > 0.0).ok_or_else(|| {
        let problem = "the frames a second are missing; mocap_frame_rate would do as well";
        archive.broken(RATES[0], problem)
    })?;
    let frame = |(pose, trans): (&[f64], &[f64])| MotionFrame {
        translations: vec![DVec3::from_slice(trans)],
        rotations: (pose.chunks_exact(3))
            .map(|v| DQuat::from_scaled_axis(DVec3::from_slice(v)))
            .collect(),
    };
    let clip = MotionClip {
        name: path
            .file_stem()
            .map_or_else(|| "motion".into(), |s| s.to_string_lossy().into_owned()),
        bones,
        parents,
        rest_joints: None,
        rest_up: UpAxis::Y,
        world_up: UpAxis::Z,
        frame_time: 1.0 / rate,
        translated: vec![0],
        frames: (poses.numbers.chunks_exact(width))
            .zip(trans.numbers.chunks_exact(3))
            .map(frame)
            .collect(),
        notes: Vec::new(),
    };
    clip.validate().map_err(|e| e.of_file(path))?;
    Ok(clip)
}

/// Names and parents of the joints of a pose of so many numbers.
fn tree(width: usize) -> Option<(Vec<String>, Vec<Option<u32>>)> {
    const HEAD: u32 = 15;
    const LEFT_WRIST: u32 = 20;
    const RIGHT_WRIST: u32 = 21;
    let (body, face, hands): (usize, &[&str], &[(&str, u32)]) = match width {
        48 => (0, &[], &[("", 0)]),
        66 => (22, &[], &[]),
        72 => (24, &[], &[]),
        156 => (22, &[], &[("left_", LEFT_WRIST), ("right_", RIGHT_WRIST)]),
        165 => (
            22,
            &["jaw", "left_eye", "right_eye"],
            &[("left_", LEFT_WRIST), ("right_", RIGHT_WRIST)],
        ),
        _ => return None,
    };
    let mut joints: Vec<(String, Option<u32>)> = (SMPL_BODY[..body].iter())
        .map(|(name, parent)| (name.to_string(), *parent))
        .collect();
    if body == 0 {
        joints.push(("wrist".into(), None));
    }
    joints.extend(face.iter().map(|name| (name.to_string(), Some(HEAD))));
    for (side, wrist) in hands {
        for finger in FINGERS {
            for k in 1..=3 {
                let parent = if k == 1 {
                    *wrist
                } else {
                    joints.len() as u32 - 1
                };
                joints.push((format!("{side}{finger}{k}"), Some(parent)));
            }
        }
    }
    Some(joints.into_iter().unzip())
}
