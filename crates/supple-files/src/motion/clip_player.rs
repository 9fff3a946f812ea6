//! A recorded clip, played on an avatar.

use super::figure::is_figure;
use super::ground::GroundMove;
use super::pose::BonePose;
use super::retarget::Retarget;
use super::retarget_options::{Align, RetargetOptions, SourceSkeleton};
use super::slides::slides;
use super::smpl::rest_joint;
use crate::motion::motion_clip::{MotionClip, MotionFrame};
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};
use supple::model::{Frame, Skeleton};
use supple::{Error, Result};

/// Where a motion takes place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// Where the avatar stands and faces; its feet stay on the ground that they stand on.
    #[default]
    Avatar,
    /// In the motion's own world.
    Motion,
}

/// How a clip is played.
#[derive(Clone, Debug, PartialEq)]
pub struct ClipOptions {
    /// How it is brought to the avatar.
    pub retarget: RetargetOptions,
    /// Frame of the clip in which the avatar's bind pose stands, in place of any alignment.
    pub rest_frame: Option<usize>,
    /// Time of the clip at which it starts, s.
    pub start: f64,
    /// Seconds of the clip a second.
    pub speed: f64,
    /// Whether it starts again when it ends, from where it ended; else it stands still.
    pub repeat: bool,
    /// Where it takes place.
    pub origin: Origin,
}

impl Default for ClipOptions {
    fn default() -> Self {
        Self {
            retarget: RetargetOptions::default(),
            rest_frame: None,
            start: 0.0,
            speed: 1.0,
            repeat: false,
            origin: Origin::Avatar,
        }
    }
}

/// A recorded clip, played on an avatar: its frames at any time.
#[derive(Clone, Debug)]
pub struct ClipPlayer {
    clip: MotionClip,
    retarget: Retarget,
    skeleton: Skeleton,
    origin: Origin,
    start: f64,
    speed: f64,
    /// Time of the clip that one round takes, and that it fades into the next one in; s.
    round: Option<(f64, f64)>,
    /// From one round to the next, in the avatar's world.
    onward: GroundMove,
    place: GroundMove,
}

impl ClipPlayer {
    /// Prepares `clip` for `skeleton`; [`ClipPlayer::stand_at`] says where it takes place.
    ///
    /// # Errors
    /// [`Error::Invalid`] of the clip, the options, or bones that cannot be mapped.
    pub fn new(mut clip: MotionClip, skeleton: &Skeleton, options: &ClipOptions) -> Result<Self> {
        clip.validate()?;
        let duration = clip.duration();
        if !(0.0..=duration).contains(&options.start) {
            let problem = format!("{} s is not within the clip's {duration} s", options.start);
            return Err(Error::invalid("start", problem));
        }
        if !(options.speed > 0.0 && options.speed.is_finite()) {
            return Err(Error::invalid("speed", "must be positive"));
        }
        // Who says what the rest pose is knows it.
        let stated = options.rest_frame.is_some() || options.retarget.align == Align::None;
        let rest = clip.rest_joints.as_ref().filter(|_| !stated);
        let figure = rest.is_none_or(|rest| is_figure(&clip.bones, rest));
        let source = SourceSkeleton {
            names: clip.bones.clone(),
            // A zero pose that is no figure says nothing about the rest.
            rest_joints: match figure {
                true => rest_joints(&clip, skeleton),
                false => vec![None; clip.bones.len()],
            },
            rest_up: Some(clip.rest_up),
            world_up: Some(clip.world_up),
        };
        let mut retarget = Retarget::new(&source, skeleton, &options.retarget)?;
        if !figure {
            let poses: Vec<_> = (clip.spread_frames().map(|f| bone_poses(&clip, f))).collect();
            retarget.fit_rest(&poses, options.retarget.scale.is_none());
            clip.notes.push(format!(
                "its zero pose is no figure, as where local axes lie along the bones: aligned by {} of its poses",
                poses.len()
            ));
        }
        if let Some(n) = options.rest_frame {
            let frame = clip.frames.get(n).ok_or_else(|| {
                let problem = format!("{n} is beyond the clip's {} frames", clip.frames.len());
                Error::invalid("rest_frame", problem)
            })?;
            retarget.rest_at(&bone_poses(&clip, frame));
        }
        let slides = slides(&clip, &followed(&clip, &retarget), figure);
        clip.notes.extend(slides);
        let mut player = Self {
            retarget,
            skeleton: skeleton.clone(),
            origin: options.origin,
            start: options.start,
            speed: options.speed,
            round: None,
            onward: GroundMove::NONE,
            place: GroundMove::NONE,
            clip,
        };
        if options.repeat {
            player.close_the_round(duration);
        }
        Ok(player)
    }

    /// Says where the avatar stands when it begins; nothing else than the motion's own world if its origin
    /// is that.
    pub fn stand_at(&mut self, standing: &[Frame]) {
        if self.origin == Origin::Avatar {
            self.place = self.place_at(standing);
        }
    }

    /// How it is brought to the avatar.
    pub fn retarget(&self) -> &Retarget {
        &self.retarget
    }

    /// The clip.
    pub fn clip(&self) -> &MotionClip {
        &self.clip
    }

    /// The avatar's frames `time` seconds after the start.
    pub fn frames(&self, time: f64) -> Vec<Frame> {
        let passed = self.speed * time.max(0.0);
        let moved = |by: &GroundMove, frames: Vec<Frame>| -> Vec<Frame> {
            frames
                .iter()
                .map(|f| self.place.apply(&by.apply(f)))
                .collect()
        };
        let Some((round, fade)) = self.round else {
            return moved(&GroundMove::NONE, self.at(self.start + passed));
        };
        let count = (passed / round).floor();
        let within = (passed - count * round).clamp(0.0, round);
        let frames = moved(
            &self.onward.repeated(count as u64),
            self.at(self.start + within),
        );
        if count < 1.0 || within >= fade {
            return frames;
        }
        let before = self.onward.repeated(count as u64 - 1);
        let before = moved(&before, self.at(self.start + round + within));
        blend(&self.skeleton, &before, &frames, within / fade)
    }

    /// Frames at a time of the clip, before they are placed.
    fn at(&self, clip_time: f64) -> Vec<Frame> {
        self.retarget.frames(&self.poses(clip_time))
    }

    fn poses(&self, clip_time: f64) -> Vec<BonePose> {
        bone_poses(&self.clip, &self.clip.sample(clip_time))
    }

    /// A clip whose last pose is its first (within 10° everywhere) has no seam; others fade.
    fn close_the_round(&mut self, duration: f64) {
        const SEAM: f64 = 0.17;
        const FADE: f64 = 0.25;
        let length = duration - self.start;
        if length <= 0.0 {
            return;
        }
        let local = |t: f64| self.clip.sample(t).rotations;
        let roots = |j: usize| self.clip.parents[j].is_none();
        let seam = (local(self.start).iter().zip(local(duration)).enumerate())
            .filter(|(j, _)| !roots(*j))
            .map(|(_, (a, b))| a.angle_between(b))
            .fold(0.0, f64::max);
        let fade = if seam > SEAM {
            FADE.min(0.25 * length)
        } else {
            0.0
        };
        let round = length - fade;
        self.round = Some((round, fade));
        let poses = self.poses(self.start);
        if let Some(anchor) = self.retarget.anchor(&poses) {
            let (first, last) = (
                self.at(self.start)[anchor],
                self.at(self.start + round)[anchor],
            );
            self.onward = GroundMove::between(&first, &last, self.retarget.up());
        }
    }

    /// Over to where the avatar stands, up or down until the feet's lowest joint of the whole clip is as
    /// high as it is there.
    fn place_at(&self, standing: &[Frame]) -> GroundMove {
        /// Frames looked at.
        const FRAMES: usize = 500;
        let up = self.retarget.up();
        let first = self.at(self.start);
        let Some(anchor) = self.retarget.anchor(&self.poses(self.start)) else {
            return GroundMove::NONE;
        };
        let over = GroundMove::between(&first[anchor], &standing[anchor], up);
        let lowest = |frames: &[Frame]| {
            let heights = self.retarget.feet().map(|j| frames[j].position.dot(up));
            heights.fold(f64::INFINITY, f64::min)
        };
        let length = self.clip.duration() - self.start;
        let times = (0..=FRAMES).map(|i| self.start + length * i as f64 / FRAMES as f64);
        let ground = times
            .map(|t| lowest(&self.at(t)))
            .fold(f64::INFINITY, f64::min);
        let rise = if ground.is_finite() {
            lowest(standing) - ground
        } else {
            (standing[anchor].position - first[anchor].position).dot(up)
        };
        over.raised(rise * up)
    }
}

/// The clip's rest joints. SMPL's poses come without: their T pose is the avatar's own if its bones have
/// SMPL's names, and else a usual one.
fn rest_joints(clip: &MotionClip, skeleton: &Skeleton) -> Vec<Option<DVec3>> {
    match &clip.rest_joints {
        Some(joints) => joints.iter().copied().map(Some).collect(),
        None if skeleton.find("left_hip").is_some() && skeleton.find("spine1").is_some() => {
            vec![None; clip.bones.len()]
        }
        None => clip.bones.iter().map(|n| rest_joint(n)).collect(),
    }
}

/// For each bone of the clip: whether its place counts, that of what drives the avatar's root and of what is above
/// it, or moves nothing of the avatar.
fn followed(clip: &MotionClip, retarget: &Retarget) -> Vec<bool> {
    let count = clip.bones.len();
    let mut moves = vec![false; count];
    for &(s, _) in &retarget.map().pairs {
        moves[s] = true;
    }
    for j in (0..count).rev() {
        if let Some(p) = clip.parents[j].filter(|_| moves[j]) {
            moves[p as usize] = true;
        }
    }
    let root = retarget.root();
    let mut above = (retarget.map().pairs.iter())
        .find(|pair| Some(pair.1) == root)
        .map(|pair| pair.0);
    while let Some(j) = above {
        moves[j] = false;
        above = clip.parents[j].map(|p| p as usize);
    }
    moves.into_iter().map(|m| !m).collect()
}

/// What a frame of a clip says of each bone: its rotation, and its place where the rest pose is known or
/// the bone is a root that moves.
fn bone_poses(clip: &MotionClip, frame: &MotionFrame) -> Vec<BonePose> {
    let rotations = clip.world_rotations(frame);
    let placed = |j: usize| {
        clip.rest_joints.is_some()
            || clip.parents[j].is_none() && clip.translated.contains(&(j as u32))
    };
    let frames = clip.world_frames(frame);
    (rotations.into_iter().zip(frames).enumerate())
        .map(|(j, (rotation, frame))| BonePose {
            rotation: Some(rotation),
            position: placed(j).then_some(frame.position),
        })
        .collect()
}

/// Frames part of the way from `a` to `b`: rotations relative to parents along the shorter arc, the
/// root's joint along the line, all joints closed.
pub fn blend(skeleton: &Skeleton, a: &[Frame], b: &[Frame], part: f64) -> Vec<Frame> {
    let local = |frames: &[Frame], j: usize| match skeleton.parents[j] {
        None => frames[j].rotation,
        Some(p) => frames[p as usize].rotation.transpose() * frames[j].rotation,
    };
    let between = |j: usize| {
        let quat = |frames| DQuat::from_mat3(&local(frames, j)).normalize();
        DMat3::from_quat(quat(a).slerp(quat(b), part))
    };
    let rotations: Vec<DMat3> = (0..skeleton.len()).map(between).collect();
    let root = a.first().zip(b.first());
    let root = root.map_or(DVec3::ZERO, |(a, b)| a.position.lerp(b.position, part));
    skeleton.forward_kinematics(&rotations, root)
}
