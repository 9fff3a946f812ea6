//! Motions of the AMASS archive and of those that took over its keys, `.npz`: SMPL's, SMPL-H's or SMPL-X's pose
//! parameters.
//!
//! | key | shape | |
//! |---|---|---|
//! | `poses` | frames × 3 joints | rotation vectors relative to the parent, rad |
//! | `root_orient`, `pose_body`, `pose_hand`, `pose_jaw`, `pose_eye` | frames × 3, 63 or 69, 90, 3, 6 | the same in parts; the first two are enough |
//! | `trans` | frames × 3 | of the root, m; z up |
//! | `mocap_framerate`, `mocap_frame_rate` or `fps` | one number | frames a second |
//! | `betas` | any | shape of the person; see [`read_betas`] |
//! | `smpl_poses`, `smpl_trans`, `smpl_scaling` | frames × 72, frames × 3, 1 | AIST++'s: y up, 60 frames a second, the way in units of `smpl_scaling` a metre |
//!
//! Mahmood et al., *AMASS: Archive of Motion Capture as Surface Shapes*, 2019; Li et al., *AI Choreographer: Music
//! Conditioned 3D Dance Generation with AIST++*, 2021. The root's joint is at J₀ + trans; `gender` is not read.

use crate::arrays::Arrays;
use crate::motion::smpl::{BODY as SMPL_BODY, FINGERS};
use crate::motion::{MotionClip, MotionFrame};
use crate::{file, npz};
use glam::{DQuat, DVec3};
use std::borrow::Cow;
use std::path::Path;
use supple::model::UpAxis;
use supple::{Error, Result};

/// Arrays that tell a motion from a body.
pub(crate) const POSES: [&str; 3] = ["poses", "root_orient", "smpl_poses"];

const RATES: [&str; 3] = ["mocap_framerate", "mocap_frame_rate", "fps"];

/// AIST++'s frames a second, which its files do not say.
const AIST_RATE: f64 = 60.0;

/// Most betas of a person: those of SMPL-X.
const MOST_BETAS: usize = 400;

/// What a file of AMASS does not say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AmassOptions {
    /// Frames a second, in place of the file's.
    pub rate: Option<f64>,
}

/// Reads the motion at `path`.
///
/// # Errors
/// [`supple::Error::Io`]; [`supple::Error::Format`] with the key, what was expected and what was found.
pub fn read_amass(path: impl AsRef<Path>) -> Result<MotionClip> {
    read_amass_with(path, &AmassOptions::default())
}

/// [`read_amass`] of a file that does not say all.
///
/// # Errors
/// As [`read_amass`]; [`supple::Error::Invalid`] of a rate that is not positive.
pub fn read_amass_with(path: impl AsRef<Path>, options: &AmassOptions) -> Result<MotionClip> {
    let path = path.as_ref();
    parse_amass_with(&file::read_bytes(path)?, path, options)
}

/// Reads a motion from a file's `bytes`; `path` names it in errors. See [`read_amass`].
pub fn parse_amass(bytes: &[u8], path: &Path) -> Result<MotionClip> {
    parse_amass_with(bytes, path, &AmassOptions::default())
}

/// The person's shape in the motion at `path`: SMPL's betas, of which models with fewer directions use the first; of the
/// first frame, where each has its own.
///
/// # Errors
/// As [`read_amass`].
pub fn read_betas(path: impl AsRef<Path>) -> Result<Vec<f64>> {
    let path = path.as_ref();
    parse_betas(&file::read_bytes(path)?, path)
}

fn parse_betas(bytes: &[u8], path: &Path) -> Result<Vec<f64>> {
    let archive = npz::parse(bytes, path, &["betas"])?;
    let missing = || archive.broken("betas", "is missing: the file says nothing of a shape");
    let array = archive.get("betas")?.ok_or_else(missing)?;
    let count = array.shape.last().copied().unwrap_or(0);
    let first = array.numbers.get(..count);
    let betas = first.filter(|_| (1..=MOST_BETAS).contains(&count));
    betas.map(<[f64]>::to_vec).ok_or_else(|| {
        let found = &array.shape;
        archive.broken(
            "betas",
            format!("shape {found:?}, expected 1 to {MOST_BETAS} numbers"),
        )
    })
}

fn parse_amass_with(bytes: &[u8], path: &Path, options: &AmassOptions) -> Result<MotionClip> {
    if options.rate.is_some_and(|r| !(r > 0.0 && r.is_finite())) {
        return Err(Error::invalid("rate", "must be positive (frames a second)"));
    }
    let parts_and_ways = [
        "pose_body",
        "pose_hand",
        "pose_jaw",
        "pose_eye",
        "trans",
        "smpl_trans",
        "smpl_scaling",
    ];
    let keys = [&POSES[..], &parts_and_ways, &RATES].concat();
    let archive = npz::parse(bytes, path, &keys)?;
    let mut notes = Vec::new();
    let Poses {
        key,
        count,
        width,
        numbers,
    } = Poses::read(&archive, &mut notes)?;
    let (bones, parents) = tree(width).ok_or_else(|| {
        let problem = format!(
            "{width} numbers a frame; SMPL has 72, its body alone 66, SMPL-H 156, SMPL-X 165, MANO 48"
        );
        archive.broken(key, problem)
    })?;
    let aist = key == "smpl_poses";
    let trans = archive.expect(
        if aist { "smpl_trans" } else { "trans" },
        &[Some(count), Some(3)],
    )?;
    let unit = if aist { scaling(&archive)? } else { 1.0 };
    let rate = rate(&archive, options, aist, &mut notes)?;
    // No motion is refused for the shape of its person.
    if let Ok(betas) = parse_betas(bytes, path) {
        notes.push(format!(
            "its {} betas are the recorded person's shape, the avatar keeps its own: `supple bake --shape-of` gives a \
             model this shape",
            betas.len()
        ));
    }
    let frame = |(pose, trans): (&[f64], &[f64])| MotionFrame {
        translations: vec![DVec3::from_slice(trans) / unit],
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
        world_up: if aist { UpAxis::Y } else { UpAxis::Z },
        frame_time: 1.0 / rate,
        translated: vec![0],
        frames: (numbers.chunks_exact(width))
            .zip(trans.numbers.chunks_exact(3))
            .map(frame)
            .collect(),
        notes,
    };
    clip.validate().map_err(|e| e.of_file(path))?;
    Ok(clip)
}

/// Pose parameters, frame after frame.
struct Poses<'a> {
    /// Where they stand.
    key: &'static str,
    count: usize,
    width: usize,
    numbers: Cow<'a, [f64]>,
}

impl<'a> Poses<'a> {
    fn read(archive: &'a Arrays, notes: &mut Vec<String>) -> Result<Self> {
        for key in ["poses", "smpl_poses"] {
            if archive.get(key)?.is_some() {
                let poses = archive.expect(key, &[None, None])?;
                return Ok(Self {
                    key,
                    count: poses.shape[0],
                    width: poses.shape[1],
                    numbers: Cow::Borrowed(&poses.numbers),
                });
            }
        }
        let (root, body) = (archive.get("root_orient")?, archive.get("pose_body")?);
        if root.is_none() || body.is_none() {
            let problem = "is missing, and so are smpl_poses, or root_orient with pose_body, which would do as well";
            return Err(archive.broken("poses", problem));
        }
        Self::joined(archive, notes)
    }

    /// The parts in the order in which `poses` has them: a face only between body and hands, as SMPL-X has it.
    fn joined(archive: &'a Arrays, notes: &mut Vec<String>) -> Result<Self> {
        let root = archive.expect("root_orient", &[None, Some(3)])?;
        let count = root.shape[0];
        let mut parts = vec![root, archive.expect("pose_body", &[Some(count), None])?];
        let mut others = Vec::new();
        for (key, width) in [("pose_jaw", 3), ("pose_eye", 6), ("pose_hand", 90)] {
            match archive.get(key)? {
                Some(part) if part.shape == [count, width] => others.push((key, part)),
                Some(part) => notes.push(format!(
                    "{key} of shape {:?} is left out: {count} frames of {width} numbers are read",
                    part.shape
                )),
                None => {}
            }
        }
        match others[..] {
            [_, _, _] => parts.extend(others.iter().map(|o| o.1)),
            _ => parts.extend(others.iter().filter(|o| o.0 == "pose_hand").map(|o| o.1)),
        }
        let mut numbers = Vec::new();
        for k in 0..count {
            for part in &parts {
                let width = part.shape[1];
                numbers.extend_from_slice(&part.numbers[k * width..(k + 1) * width]);
            }
        }
        Ok(Self {
            key: "pose_body",
            count,
            width: parts.iter().map(|p| p.shape[1]).sum(),
            numbers: Cow::Owned(numbers),
        })
    }
}

/// Units of AIST++'s way a metre: its people were fitted in the cameras' unit.
fn scaling(archive: &Arrays) -> Result<f64> {
    let Some(array) = archive.get("smpl_scaling")? else {
        return Ok(1.0);
    };
    let scaling = array.numbers.first().copied().filter(|s| *s > 0.0);
    scaling.ok_or_else(|| archive.broken("smpl_scaling", "must be a positive number"))
}

/// Frames a second.
fn rate(
    archive: &Arrays,
    options: &AmassOptions,
    aist: bool,
    notes: &mut Vec<String>,
) -> Result<f64> {
    if let Some(rate) = options.rate {
        return Ok(rate);
    }
    for key in RATES {
        let rate = archive.get(key)?.and_then(|r| r.numbers.first().copied());
        if let Some(rate) = rate.filter(|r| *r > 0.0) {
            return Ok(rate);
        }
    }
    if aist {
        notes.push(format!(
            "it does not say its rate: the {AIST_RATE} frames a second of AIST++ are taken; `rate` states another"
        ));
        return Ok(AIST_RATE);
    }
    let problem = "the frames a second are missing: state them by `rate = 60` in the scene's [motion], or by --rate 60";
    Err(archive.broken(RATES[0], problem))
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
