//! `supple motion`.

use super::motion_flags::MotionFlags;
use super::terminal::{print, print_json, print_table};
use glam::DVec3;
use serde::Serialize;
use std::path::PathBuf;
use supple::model::{Frame, Skeleton, UpAxis};
use supple::{Error, Result};
use supple_files::{
    BoneMap, BonePoses, MotionClip, PoseHeader, clip_as_poses, pose_header_line, pose_line,
    read_pose,
};
use supple_pictures::{Figure, motion_strip};
use supple_scene::{Playback, TrackedMotion, avatar_source_of, read_motion};

/// Arguments of `supple motion`.
#[derive(clap::Args)]
pub struct Arguments {
    /// A motion: .bvh, .npz (AMASS), .glb, .vrma, .jsonl, .js or .json. Several poses (.js, .json) make a stream.
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Write it to stdout as a stream of poses, JSON lines; poses come --every so many seconds [default: 1].
    #[arg(long)]
    jsonl: bool,
    /// A character, recipe or scene that follows it; says which bones are mapped.
    #[arg(long)]
    avatar: Option<PathBuf>,
    /// Draw it: figures side by side, without physics.
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Figures of the picture.
    #[arg(long, default_value_t = 8)]
    figures: usize,
    /// Seconds from one figure to the next [default: the clip's length in equal parts].
    #[arg(long)]
    every: Option<f64>,
    #[command(flatten)]
    of_motion: MotionFlags,
    /// JSON in place of a table.
    #[arg(long, conflicts_with = "jsonl")]
    json: bool,
}

/// What is in a motion, and how an avatar follows it.
#[derive(Serialize)]
struct Contents<'a> {
    name: Option<&'a str>,
    frames: Option<usize>,
    /// s.
    frame_time: Option<f64>,
    bones: &'a [String],
    /// Which bones are mapped; without an avatar to itself.
    map: &'a BoneMap,
    /// Metres of the avatar's way for one of the motion's.
    scale: f64,
    notes: &'a [String],
}

impl Arguments {
    /// Says what is in a motion, and draws it.
    pub fn run(self) -> Result<()> {
        let motion = (self.of_motion).of(TrackedMotion::of_file(&self.files[0]));
        let clip = read_motion(&motion)?;
        if self.jsonl {
            return self.write_lines(clip);
        }
        if self.files.len() > 1 {
            let problem =
                "several make a stream: add --jsonl, and give that to simulate --motion -";
            return Err(Error::invalid("FILES", problem));
        }
        if let Some(clip) = clip.as_ref().filter(|_| !self.json) {
            print_table([
                ("motion", clip.name.clone()),
                (
                    "frames",
                    format!("{} of {:.6} s", clip.frames.len(), clip.frame_time),
                ),
                ("duration", format!("{:.3} s", clip.duration())),
                ("bones", clip.bones.join(", ")),
            ]);
        }
        let body = match &self.avatar {
            Some(path) => Some(avatar_source_of(path)?.body()?.0),
            None => None,
        };
        let own = clip.as_ref().map(|c| Skeleton {
            names: c.bones.clone(),
            parents: c.parents.clone(),
            joints: (c.rest_joints.clone()).unwrap_or_else(|| vec![DVec3::ZERO; c.bones.len()]),
            aliases: Vec::new(),
            limits: Vec::new(),
        });
        let (figure, skeleton) = match (&body, &own) {
            (Some(body), _) => (Figure::Skin(body), &body.skeleton),
            (None, Some(own)) => (Figure::Sticks(own), own),
            (None, None) => {
                let problem = "poses have no skeleton of their own: give one with --avatar";
                return Err(Error::invalid("--avatar", problem));
            }
        };
        let own_up = clip.as_ref().map(|c| c.rest_up);
        let avatar_up = (body.as_ref().map(|b| b.up).or(own_up)).unwrap_or_default();
        let mut playback = Playback::open(&motion, skeleton, avatar_up, UpAxis::Z)?;
        let retarget = playback.retarget();
        if self.json {
            print_json(&Contents {
                name: clip.as_ref().map(|c| c.name.as_str()),
                frames: clip.as_ref().map(|c| c.frames.len()),
                frame_time: clip.as_ref().map(|c| c.frame_time),
                bones: clip.as_ref().map_or(&[], |c| &c.bones),
                map: retarget.map(),
                scale: retarget.scale(),
                notes: playback.notes(),
            })?;
        } else {
            print_table(playback.notes().iter().map(|note| ("note", note.clone())));
            if body.is_some() {
                print(format_args!("{}", retarget.map().summary()));
                print(format_args!("scale of the way {:.4}", retarget.scale()));
            }
        }
        let standing = Frame {
            rotation: playback.retarget().standing(),
            position: DVec3::ZERO,
        };
        let bind = skeleton.bind_pose();
        playback.stand_at(&bind.iter().map(|f| standing.compose(f)).collect::<Vec<_>>());
        let Some(output) = &self.output else {
            return Ok(());
        };
        let whole = clip.map_or(0.0, |c| c.duration());
        let figures = self.figures.clamp(1, 64);
        let every = self
            .every
            .unwrap_or(whole / figures.saturating_sub(1).max(1) as f64);
        let pose = |k: usize| {
            let time = every * k as f64;
            Ok((format!("{time:.2} s"), playback.frames(time)?))
        };
        let poses: Vec<_> = (0..figures).map(pose).collect::<Result<_>>()?;
        // From the front and the left of what faces −y.
        let view = DVec3::new(-0.8, 0.6, -0.15);
        motion_strip(&figure, &poses, view, DVec3::Z, [240, 420]).write_png(output)?;
        if !self.json {
            print(format_args!("written to {}", output.display()));
        }
        Ok(())
    }

    /// A clip, or poses one after the other.
    fn write_lines(&self, clip: Option<MotionClip>) -> Result<()> {
        let (header, poses) = match clip {
            Some(clip) => clip_as_poses(&clip)?,
            None => {
                let mut header = PoseHeader::default();
                let mut poses = Vec::new();
                for (k, path) in self.files.iter().enumerate() {
                    let (its, pose) = read_pose(path)?;
                    header = its;
                    let time = self.every.unwrap_or(1.0) * k as f64;
                    poses.push(BonePoses { time, ..pose });
                }
                (header, poses)
            }
        };
        let lines: String = poses.iter().map(pose_line).collect();
        print(format_args!(
            "{}{}",
            pose_header_line(&header),
            lines.trim_end()
        ));
        Ok(())
    }
}
