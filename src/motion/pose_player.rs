//! A stream of poses, played on an avatar as it comes in.

use super::clip_player::Origin;
use super::ground::GroundMove;
use super::pose::{BonePose, BonePoses, PoseHeader};
use super::retarget::{Retarget, RetargetOptions, SourceSkeleton};
use crate::model::{Frame, Skeleton};
use crate::{Error, Result};
use std::collections::BTreeMap;

/// Where poses come from: each call gives the next one, `None` after the last. It may wait.
pub type NextPose<'a> = dyn FnMut() -> Result<Option<BonePoses>> + 'a;

/// How a stream is played.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseOptions {
    /// How poses are brought to the avatar.
    pub retarget: RetargetOptions,
    /// Where they take place; in the scene's own world if the stream does not state its axes, else where
    /// the avatar stands.
    pub origin: Option<Origin>,
}

/// A stream of poses, played on an avatar. The first pose names every bone; later ones may leave bones
/// out, which then stay. Between two poses places go along lines, rotations along the shorter arc.
#[derive(Clone, Debug)]
pub struct PosePlayer {
    skeleton: Skeleton,
    standing: Vec<Frame>,
    options: PoseOptions,
    header: PoseHeader,
    /// From the first pose on.
    playing: Option<Playing>,
}

#[derive(Clone, Debug)]
struct Playing {
    names: BTreeMap<String, usize>,
    retarget: Retarget,
    place: GroundMove,
    /// Time of the first pose: the stream's 0, s.
    first: f64,
    before: (f64, Vec<BonePose>),
    after: (f64, Vec<BonePose>),
    ended: bool,
}

impl PosePlayer {
    /// A player for `skeleton`, which stands at `standing` when it begins.
    pub fn new(
        header: PoseHeader,
        skeleton: &Skeleton,
        standing: &[Frame],
        options: PoseOptions,
    ) -> Self {
        Self {
            skeleton: skeleton.clone(),
            standing: standing.to_vec(),
            options,
            header,
            playing: None,
        }
    }

    /// Takes in the first pose, and says how it is brought to the avatar.
    ///
    /// # Errors
    /// What `next` says; [`Error::Invalid`] where there is no pose or no bone can be mapped.
    pub fn begin(&mut self, next: &mut NextPose<'_>) -> Result<&Retarget> {
        if self.playing.is_none() {
            let first = next()?.ok_or_else(|| Error::invalid("motion", "holds no pose"))?;
            self.playing = Some(self.prepare(&first)?);
        }
        match &self.playing {
            Some(playing) => Ok(&playing.retarget),
            None => Err(Error::invalid("motion", "holds no pose")),
        }
    }

    /// The avatar's frames `time` seconds after the first pose. Times must not fall.
    ///
    /// # Errors
    /// As [`PosePlayer::begin`]; [`Error::Invalid`] of a bone that the first pose did not name.
    pub fn frames(&mut self, time: f64, next: &mut NextPose<'_>) -> Result<Vec<Frame>> {
        self.begin(next)?;
        let Some(playing) = &mut self.playing else {
            return Ok(self.standing.clone());
        };
        while !playing.ended && playing.after.0 < time {
            match next()? {
                Some(poses) => playing.add(&poses, &self.header)?,
                None => playing.ended = true,
            }
        }
        let ((t0, before), (t1, after)) = (&playing.before, &playing.after);
        let part = if t1 > t0 {
            ((time - t0) / (t1 - t0)).clamp(0.0, 1.0)
        } else {
            1.0
        };
        let poses: Vec<BonePose> = before
            .iter()
            .zip(after)
            .map(|(a, b)| a.towards(b, part))
            .collect();
        Ok(playing.placed(&poses, &self.standing))
    }

    fn prepare(&self, first: &BonePoses) -> Result<Playing> {
        let names: BTreeMap<String, usize> = (first.bones.keys().cloned().zip(0..)).collect();
        let rest = |name: &String| self.header.rest.get(name);
        let source = SourceSkeleton {
            rest_joints: names.keys().map(|n| rest(n)?.position).collect(),
            rest_up: self.header.up.unwrap_or_default(),
            world_up: self.header.up,
            names: names.keys().cloned().collect(),
        };
        let retarget = Retarget::new(&source, &self.skeleton, &self.options.retarget)?;
        let unknown = vec![BonePose::default(); names.len()];
        let mut playing = Playing {
            names,
            retarget,
            place: GroundMove::NONE,
            first: first.time,
            before: (0.0, unknown.clone()),
            after: (0.0, unknown),
            ended: false,
        };
        playing.add(first, &self.header)?;
        playing.before = playing.after.clone();
        let origin = self.options.origin.unwrap_or(match self.header.up {
            Some(_) => Origin::Avatar,
            None => Origin::Motion,
        });
        let poses = &playing.after.1;
        if origin == Origin::Avatar
            && let Some(anchor) = playing.retarget.anchor(poses)
        {
            let (from, to) = (
                playing.retarget.frames(poses)[anchor],
                self.standing[anchor],
            );
            let up = playing.retarget.up();
            playing.place = GroundMove::between(&from, &to, up)
                .raised(up * (to.position - from.position).dot(up));
        }
        Ok(playing)
    }
}

impl Playing {
    /// Takes in a pose of the source.
    fn add(&mut self, poses: &BonePoses, header: &PoseHeader) -> Result<()> {
        let mut bones = self.after.1.clone();
        for (name, pose) in &poses.bones {
            let Some(&at) = self.names.get(name) else {
                let problem = format!(
                    "at {} s the bone {name:?} is new; the first pose must name every bone",
                    poses.time
                );
                return Err(Error::invalid("motion", problem));
            };
            let rest = header.rest.get(name).and_then(|r| r.rotation);
            bones[at] = BonePose {
                rotation: match (pose.rotation, rest) {
                    (Some(now), Some(rest)) => Some((now * rest.inverse()).normalize()),
                    (now, _) => now,
                }
                .or(bones[at].rotation),
                position: pose.position.or(bones[at].position),
            };
        }
        let time = poses.time - self.first;
        self.before = std::mem::replace(&mut self.after, (time, bones));
        Ok(())
    }

    /// The avatar's frames where they take place. Without a known place its root stays.
    fn placed(&self, poses: &[BonePose], standing: &[Frame]) -> Vec<Frame> {
        let mut frames = self.retarget.frames(poses);
        if self.retarget.anchor(poses).is_none() {
            let root = standing[0].position;
            frames.iter_mut().for_each(|f| f.position += root);
            return frames;
        }
        frames.iter().map(|f| self.place.apply(f)).collect()
    }
}
