//! What a simulation follows.

use crate::error::{OrRaise, invalid, to_python};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::depythonize;
use std::path::PathBuf;
use supple::Error;
use supple::model::{Avatar, Frame, UpAxis};
use supple::skeleton::Spring;
use supple::world::Character;
use supple_files::{ClipPlayer, MotionClip};
use supple_scene::{Playback, TrackedMotion};

/// How bones go where they are driven to.
#[derive(Clone, Copy, Debug)]
pub enum Grip {
    /// Exactly.
    Exact,
    /// Drawn by springs of the rotation and of the position.
    Springs(Spring, Spring),
}

/// Where bones are driven to.
pub enum Motion {
    /// Nowhere: the bind pose, or nothing at all.
    None,
    /// To these frames, until others are given.
    Frames(Vec<Frame>),
    /// Along poses of the avatar's own bones.
    Poses(Box<MotionClip>),
    /// The same, a pose a step.
    Steps(Box<MotionClip>),
    /// Along a file's motion.
    File(Box<ClipPlayer>),
}

impl Motion {
    /// The motion in the file at `path`, for an avatar that stands at `standing`; `options` are keys of a scene's `[motion]`.
    pub fn open(
        path: PathBuf,
        rate: Option<f64>,
        options: Option<&Bound<'_, PyDict>>,
        avatar: &Avatar,
        up: UpAxis,
        standing: &[Frame],
    ) -> PyResult<Self> {
        let mut options: TrackedMotion = match options {
            None => TrackedMotion::default(),
            Some(options) => depythonize(options.as_any()).map_err(|e| {
                invalid(
                    "options",
                    format!("{e}; docs/scenes.md has the keys of [motion]"),
                )
            })?,
        };
        options.file = path;
        options.rate = rate.or(options.rate);
        let skeleton = avatar.character();
        match Playback::open(&options, &skeleton, avatar.up, up).or_raise()? {
            Playback::Clip(mut player) => {
                player.stand_at(standing);
                Ok(Self::File(player))
            }
            Playback::Poses(_) => {
                let problem =
                    "is a stream of poses: read it here, and follow() each pose before its step";
                Err(to_python(Error::format(&options.file, "poses", problem)))
            }
        }
    }

    /// How far a step of `dt` goes along it: as many seconds, or to the next pose.
    pub fn advance(&self, dt: f64) -> f64 {
        match self {
            Self::Steps(clip) => clip.frame_time,
            _ => dt,
        }
    }

    /// Where the bones are `time` seconds of the motion after its start; none where they are not driven.
    pub fn frames(&self, time: f64) -> Option<Vec<Frame>> {
        match self {
            Self::None => None,
            Self::Frames(frames) => Some(frames.clone()),
            Self::Poses(clip) | Self::Steps(clip) => Some(clip.world_frames(&clip.sample(time))),
            Self::File(player) => Some(player.frames(time)),
        }
    }

    /// The clip, where there is one: time between its frames, s, and how many there are.
    pub fn extent(&self) -> Option<(f64, usize)> {
        let clip = match self {
            Self::Poses(clip) | Self::Steps(clip) => clip,
            Self::File(player) => player.clip(),
            _ => return None,
        };
        Some((clip.frame_time, clip.frames.len()))
    }

    /// Whether bones are on the way at the start.
    pub fn moves(&self) -> bool {
        self.extent().is_some_and(|(_, frames)| frames > 1)
    }

    /// What was decided about its file.
    pub fn notes(&self) -> Vec<String> {
        match self {
            Self::File(player) => {
                let mut notes = vec![player.retarget().map().summary()];
                notes.extend(player.clip().notes.iter().cloned());
                notes
            }
            _ => Vec::new(),
        }
    }
}

/// Gives a character the frames of the next step's end.
pub fn drive(character: &mut Character, frames: &[Frame], grip: Grip) -> supple::Result<()> {
    match grip {
        Grip::Exact => character.follow_frames(frames),
        Grip::Springs(rotation, position) => character.track_frames(frames, rotation, position),
    }
}
