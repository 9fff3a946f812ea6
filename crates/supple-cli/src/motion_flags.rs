//! How a motion is taken: what a scene's `[motion]` would say of it, as flags.

use std::path::PathBuf;
use supple::{Error, Result};
use supple_scene::TrackedMotion;

/// How a motion is taken.
#[derive(clap::Args)]
pub struct MotionFlags {
    /// Which of a glTF file's animations [default: the first].
    #[arg(long)]
    clip: Option<String>,
    /// Frames a second of the motion, in place of what a .bvh or .npz says.
    #[arg(long)]
    rate: Option<f64>,
    /// Bones that names do not match: MOTION'S=AVATAR'S,… ; nothing after = leaves a bone out.
    #[arg(long, value_name = "BONE=BONE", value_delimiter = ',', value_parser = pair)]
    map: Vec<(String, String)>,
}

fn pair(text: &str) -> std::result::Result<(String, String), String> {
    let (from, to) = text
        .split_once('=')
        .ok_or("needs a bone of the motion, =, and one of the avatar")?;
    match from.trim() {
        "" => Err("needs a bone of the motion before =".into()),
        from => Ok((from.into(), to.trim().into())),
    }
}

impl MotionFlags {
    /// Says it of `motion`.
    ///
    /// # Errors
    /// Of a flag where there is no motion.
    pub fn apply(&self, motion: Option<TrackedMotion>) -> Result<Option<TrackedMotion>> {
        let given = [
            ("--clip", self.clip.is_some()),
            ("--rate", self.rate.is_some()),
            ("--map", !self.map.is_empty()),
        ];
        match (motion, given.iter().find(|flag| flag.1)) {
            (None, Some((flag, _))) => {
                let problem = "is of a motion, and there is none: give --motion";
                Err(Error::invalid(*flag, problem))
            }
            (motion, _) => Ok(motion.map(|motion| self.of(motion))),
        }
    }

    /// `motion`, taken as the flags say.
    pub fn of(&self, mut motion: TrackedMotion) -> TrackedMotion {
        motion.map.extend(self.map.iter().cloned());
        TrackedMotion {
            clip: self.clip.clone().or(motion.clip),
            rate: self.rate.or(motion.rate),
            ..motion
        }
    }
}

/// `motion` with its file replaced by `file`.
pub fn from_file(motion: Option<TrackedMotion>, file: Option<&PathBuf>) -> Option<TrackedMotion> {
    let Some(file) = file.cloned() else {
        return motion;
    };
    Some(match motion {
        Some(motion) => TrackedMotion { file, ..motion },
        None => TrackedMotion::of_file(file),
    })
}
