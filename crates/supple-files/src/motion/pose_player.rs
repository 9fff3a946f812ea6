//! A stream of poses, played on an avatar as it comes in.

use super::clip_player::Origin;
use super::figure::is_figure;
use super::ground::GroundMove;
use super::pose::{BonePose, BonePoses, PoseHeader};
use super::retarget::Retarget;
use super::retarget_options::{Align, RetargetOptions, SourceSkeleton};
use glam::DVec3;
use std::collections::BTreeMap;
use supple::model::{Frame, Skeleton};
use supple::{Error, Result};

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
    header: PoseHeader,
    names: BTreeMap<String, usize>,
    retarget: Retarget,
    origin: Origin,
    /// Where the root stays if no place is known.
    root: DVec3,
    place: GroundMove,
    /// Time of the first pose: the stream's 0, s.
    first: f64,
    before: (f64, Vec<BonePose>),
    after: (f64, Vec<BonePose>),
    ended: bool,
}

impl PosePlayer {
    /// A player for `skeleton` of what begins with the pose `first`; [`PosePlayer::stand_at`] says where it
    /// takes place.
    ///
    /// # Errors
    /// [`Error::Invalid`] of the options, or where no bone can be mapped.
    pub fn new(
        header: PoseHeader,
        first: &BonePoses,
        skeleton: &Skeleton,
        options: &PoseOptions,
    ) -> Result<Self> {
        let names: BTreeMap<String, usize> = (first.bones.keys().cloned().zip(0..)).collect();
        let rest_joints = names.keys().map(|n| header.rest.get(n)?.position);
        let mut rest_joints: Vec<Option<DVec3>> = rest_joints.collect();
        let bones: Vec<String> = names.keys().cloned().collect();
        let known: Option<Vec<DVec3>> = rest_joints.iter().copied().collect();
        let figure = options.retarget.align == Align::None
            || known.is_none_or(|rest| is_figure(&bones, &rest));
        if !figure {
            // It says nothing about the rest; the first pose does.
            rest_joints.fill(None);
        }
        let source = SourceSkeleton {
            rest_joints,
            rest_up: header.up.filter(|_| !header.rest.is_empty()),
            world_up: header.up,
            names: bones,
        };
        let unknown = vec![BonePose::default(); names.len()];
        let mut player = Self {
            retarget: Retarget::new(&source, skeleton, &options.retarget)?,
            origin: options.origin.unwrap_or(match header.up {
                Some(_) => Origin::Avatar,
                None => Origin::Motion,
            }),
            root: skeleton.joints[0],
            place: GroundMove::NONE,
            first: first.time,
            before: (0.0, unknown.clone()),
            after: (0.0, unknown),
            ended: false,
            header,
            names,
        };
        player.add(first)?;
        if !figure {
            let poses = [player.after.1.clone()];
            let resize = options.retarget.scale.is_none();
            player.retarget.fit_rest(&poses, resize);
        }
        player.before = player.after.clone();
        Ok(player)
    }

    /// How poses are brought to the avatar.
    pub fn retarget(&self) -> &Retarget {
        &self.retarget
    }

    /// Says where the avatar stands when it begins: the first pose is taken there, unless its origin is the
    /// motion's own world.
    pub fn stand_at(&mut self, standing: &[Frame]) {
        let poses = &self.after.1;
        self.root = standing[0].position;
        let Some(anchor) = self.retarget.anchor(poses) else {
            return;
        };
        if self.origin == Origin::Avatar {
            let (from, to) = (self.retarget.frames(poses)[anchor], standing[anchor]);
            let up = self.retarget.up();
            let rise = up * (to.position - from.position).dot(up);
            self.place = GroundMove::between(&from, &to, up).raised(rise);
        }
    }

    /// The avatar's frames `time` seconds after the first pose. Times must not fall.
    ///
    /// # Errors
    /// What `next` says; [`Error::Invalid`] of a bone that the first pose did not name.
    pub fn frames(&mut self, time: f64, next: &mut NextPose<'_>) -> Result<Vec<Frame>> {
        while !self.ended && self.after.0 < time {
            match next()? {
                Some(poses) => self.add(&poses)?,
                None => self.ended = true,
            }
        }
        let ((t0, before), (t1, after)) = (&self.before, &self.after);
        let part = match t1 > t0 {
            true => ((time - t0) / (t1 - t0)).clamp(0.0, 1.0),
            false => 1.0,
        };
        let poses: Vec<BonePose> = (before.iter().zip(after))
            .map(|(a, b)| a.towards(b, part))
            .collect();
        let mut frames = self.retarget.frames(&poses);
        match self.retarget.anchor(&poses) {
            Some(_) => frames.iter_mut().for_each(|f| *f = self.place.apply(f)),
            None => frames.iter_mut().for_each(|f| f.position += self.root),
        }
        Ok(frames)
    }

    /// Takes in a pose of the source.
    fn add(&mut self, poses: &BonePoses) -> Result<()> {
        let mut bones = self.after.1.clone();
        for (name, pose) in &poses.bones {
            let Some(&at) = self.names.get(name) else {
                let problem = format!(
                    "at {} s the bone {name:?} is new; the first pose must name every bone",
                    poses.time
                );
                return Err(Error::invalid("motion", problem));
            };
            let rest = self.header.rest.get(name).and_then(|r| r.rotation);
            let turned = match (pose.rotation, rest) {
                (Some(now), Some(rest)) => Some((now * rest.inverse()).normalize()),
                (now, _) => now,
            };
            bones[at] = BonePose {
                rotation: turned.or(bones[at].rotation),
                position: pose.position.or(bones[at].position),
            };
        }
        let time = poses.time - self.first;
        self.before = std::mem::replace(&mut self.after, (time, bones));
        Ok(())
    }
}
