//! A motion from a file of any format, played on an avatar.

use crate::motion::tracked::TrackedMotion;
use std::fs::File;
use std::io::{Read, stdin};
use std::path::Path;
use supple::model::{Frame, Skeleton, UpAxis};
use supple::{Error, Result};
use supple_files::{
    AmassOptions, BonePoses, BvhOptions, ClipPlayer, MotionClip, PoseHeader, PosePlayer,
    PoseReader, Retarget, mirrored_clip, mirrored_header, mirrored_poses, read_amass_with,
    read_bvh, read_gltf_motions, read_pose,
};

/// A motion on an avatar: frames for every time step.
pub enum Playback {
    /// A clip in memory.
    Clip(Box<ClipPlayer>),
    /// Poses that are read as time goes on.
    Poses(Box<PoseFeed>),
}

/// Poses, and where they come from.
pub struct PoseFeed {
    player: PosePlayer,
    reader: Option<PoseReader<Box<dyn Read + Send>>>,
    mirror: bool,
    speed: f64,
    start: f64,
}

impl Playback {
    /// Opens the file of `motion` for `skeleton`, in whose reference shape `avatar_up` points up, in a world where `up`
    /// does. A stream's first pose is waited for.
    ///
    /// # Errors
    /// [`Error::Io`] and [`Error::Format`] of the file; [`Error::Invalid`] of a key, or of bones that cannot
    /// be mapped.
    pub fn open(
        motion: &TrackedMotion,
        skeleton: &Skeleton,
        avatar_up: UpAxis,
        up: UpAxis,
    ) -> Result<Self> {
        motion.validate()?;
        let path = motion.file.as_path();
        let of_file = |e: Error| e.within("motion").of_file(path);
        if let Some(clip) = read_motion(motion)? {
            let clip = if motion.mirror {
                mirrored_clip(&clip)
            } else {
                clip
            };
            let player = ClipPlayer::new(clip, skeleton, &motion.clip_options(avatar_up, up))
                .map_err(of_file)?;
            return Ok(Self::Clip(Box::new(player)));
        }
        if motion.repeat || motion.rest_frame.is_some() {
            let problem = "loop and rest_frame are for clips, not for poses as they come in";
            return Err(Error::format(path, "motion", problem));
        }
        let (mut header, first, reader) = open_poses(path)?;
        header.up = motion.up.or(header.up);
        let (header, first) = match motion.mirror {
            true => (mirrored_header(&header), mirrored_poses(&first)),
            false => (header, first),
        };
        let player = PosePlayer::new(
            header,
            &first,
            skeleton,
            &motion.pose_options(avatar_up, up),
        );
        Ok(Self::Poses(Box::new(PoseFeed {
            player: player.map_err(of_file)?,
            reader,
            mirror: motion.mirror,
            speed: motion.speed,
            start: motion.start,
        })))
    }

    /// How it is brought to the avatar.
    pub fn retarget(&self) -> &Retarget {
        match self {
            Self::Clip(player) => player.retarget(),
            Self::Poses(feed) => feed.player.retarget(),
        }
    }

    /// What was decided about a clip's file, and what of it the avatar cannot follow; a sentence each.
    pub fn notes(&self) -> &[String] {
        match self {
            Self::Clip(player) => &player.clip().notes,
            Self::Poses(_) => &[],
        }
    }

    /// Says where the avatar stands when it begins.
    pub fn stand_at(&mut self, standing: &[Frame]) {
        match self {
            Self::Clip(player) => player.stand_at(standing),
            Self::Poses(feed) => feed.player.stand_at(standing),
        }
    }

    /// The avatar's frames `time` seconds after the start; times must not fall. A stream is waited for.
    ///
    /// # Errors
    /// What reading the stream says.
    pub fn frames(&mut self, time: f64) -> Result<Vec<Frame>> {
        match self {
            Self::Clip(player) => Ok(player.frames(time)),
            Self::Poses(feed) => feed.frames(time),
        }
    }
}

impl PoseFeed {
    fn frames(&mut self, time: f64) -> Result<Vec<Frame>> {
        let Self {
            player,
            reader,
            mirror,
            ..
        } = self;
        let mut next = || -> Result<Option<BonePoses>> {
            let Some(reader) = reader else {
                return Ok(None);
            };
            let poses = reader.next_pose()?;
            Ok(match *mirror {
                true => poses.as_ref().map(mirrored_poses),
                false => poses,
            })
        };
        player.frames(self.start + self.speed * time, &mut next)
    }
}

/// The clip in the file of `motion`; `None` if it holds poses.
///
/// # Errors
/// [`Error::Io`] and [`Error::Format`] of the file; [`Error::Invalid`] of a key.
pub fn read_motion(motion: &TrackedMotion) -> Result<Option<MotionClip>> {
    motion.validate()?;
    let path = motion.file.as_path();
    if motion.is_standard_input() {
        return Ok(None);
    }
    let extension = path
        .extension()
        .map(|e| e.to_string_lossy().to_ascii_lowercase());
    let mut clip = match extension.as_deref() {
        Some("bvh") => read_bvh(
            path,
            &BvhOptions {
                unit: motion.unit.clone(),
                up: motion.up,
            },
        )?,
        Some("npz") => read_amass_with(path, &AmassOptions { rate: motion.rate })?,
        Some("glb" | "gltf" | "vrm" | "vrma") if motion.rate.is_some() => {
            let problem = "is of .bvh and .npz files: an animation has times of its own; `speed` changes them";
            return Err(Error::format(path, "motion.rate", problem));
        }
        Some("glb" | "gltf" | "vrm" | "vrma") => named_clip(read_gltf_motions(path)?, motion)?,
        Some("jsonl" | "ndjson" | "js" | "json") => return Ok(None),
        _ => {
            let problem = "is of no known kind: .bvh, .npz, .glb, .gltf, .vrm, .vrma, .jsonl, .js and .json are";
            return Err(Error::format(path, "motion.file", problem));
        }
    };
    clip.world_up = motion.up.unwrap_or(clip.world_up);
    clip.frame_time = motion.rate.map_or(clip.frame_time, f64::recip);
    Ok(Some(clip))
}

/// The animation that is asked for; the first if none is.
fn named_clip(clips: Vec<MotionClip>, motion: &TrackedMotion) -> Result<MotionClip> {
    let names: Vec<String> = clips.iter().map(|c| c.name.clone()).collect();
    let wanted = |c: &MotionClip| motion.clip.as_ref().is_none_or(|name| *name == c.name);
    clips.into_iter().find(wanted).ok_or_else(|| {
        let problem = match (&motion.clip, &names[..]) {
            (_, []) => "holds no animation".to_string(),
            (Some(name), names) => {
                format!("there is no clip {name:?}; there are {}", names.join(", "))
            }
            (None, names) => format!("name one of {}", names.join(", ")),
        };
        Error::format(&motion.file, "motion.clip", problem)
    })
}

type Poses = (
    PoseHeader,
    BonePoses,
    Option<PoseReader<Box<dyn Read + Send>>>,
);

/// What comes before the poses, the first of them, and where others come from.
fn open_poses(path: &Path) -> Result<Poses> {
    let extension = path
        .extension()
        .map(|e| e.to_string_lossy().to_ascii_lowercase());
    if matches!(extension.as_deref(), Some("js" | "json")) {
        let (header, poses) = read_pose(path)?;
        return Ok((header, poses, None));
    }
    let (bytes, name): (Box<dyn Read + Send>, &Path) = if path == Path::new("-") {
        (Box::new(stdin()), Path::new("standard input"))
    } else {
        (
            Box::new(File::open(path).map_err(|e| Error::io(path, e))?),
            path,
        )
    };
    let mut reader = PoseReader::new(bytes, name);
    let header = reader.header()?;
    let first = reader.next_pose()?;
    let first = first.ok_or_else(|| Error::format(name, "motion", "holds no pose"))?;
    Ok((header, first, Some(reader)))
}
