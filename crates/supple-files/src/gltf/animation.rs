//! Animations as motions of the bones, away from the reference shape.

use super::container::File;
use super::document::Animation;
use super::nodes::{Local, Nodes, same_scale, similarity};
use super::rig::{Rig, name};
use super::sampler::{Property, Track};
use crate::motion::{MotionClip, MotionFrame};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use std::collections::BTreeMap;
use supple::Result;
use supple::model::{Frame, UpAxis};

/// Most placements of nodes that are computed for one animation.
const MOST_PLACEMENTS: f64 = (1 << 24) as f64;

/// Frames a second at which keys may lie; one of them usually fits, and 120 is near enough to any.
const RATES: [f64; 9] = [24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0];

/// Lowest number of frames a second: between frames a motion is interpolated linearly.
const LEAST_RATE: f64 = 60.0;

/// A joint that stays this near to its rest place does not move: relative to the skeleton's extent, for
/// the rounding of its file, and in m.
const STILL: [f64; 2] = [2e-7, 3e-7];

/// The motions of a file; animations that move no bone are left out.
pub(super) fn motions(file: &File, nodes: &Nodes, rig: &Rig) -> Result<Vec<MotionClip>> {
    let mut clips = Vec::new();
    for (i, animation) in file.document.animations.iter().enumerate() {
        let field = format!("animations[{i}]");
        clips.extend(Player::new(file, nodes, rig, animation, field)?.clip()?);
    }
    Ok(clips)
}

struct Player<'a> {
    file: &'a File,
    nodes: &'a Nodes,
    rig: &'a Rig,
    field: String,
    name: String,
    tracks: Vec<Track>,
    /// Bones and what is above them, parents first.
    needed: Vec<usize>,
    /// Q and scale of each bone's node at rest: R(t) = Q(t) Qᵀ R_rest.
    rest: Vec<(DMat3, f64)>,
}

impl<'a> Player<'a> {
    fn new(
        file: &'a File,
        nodes: &'a Nodes,
        rig: &'a Rig,
        animation: &Animation,
        field: String,
    ) -> Result<Self> {
        let mut is_needed = vec![false; nodes.parents.len()];
        for &n in nodes.order.iter().rev() {
            is_needed[n] |= rig.bone_of_node[n].is_some();
            if let Some(p) = nodes.parents[n] {
                is_needed[p] |= is_needed[n];
            }
        }
        let mut tracks = Vec::new();
        for (c, channel) in animation.channels.iter().enumerate() {
            let field = format!("{field}.channels[{c}]");
            let track = Track::read(file, &field, channel, &animation.samplers)?;
            tracks.extend(track.filter(|t| is_needed[t.node]));
        }
        let rest = rig.nodes.iter().map(|&n| {
            let found = similarity(nodes.rest_world[n].matrix3);
            found
                .map(|s| (s.rotation, s.scale))
                .map_err(|e| file.broken(format!("nodes[{n}]"), e))
        });
        Ok(Self {
            file,
            nodes,
            rig,
            name: animation.name.clone().unwrap_or_else(|| field.clone()),
            field,
            tracks,
            needed: nodes
                .order
                .iter()
                .copied()
                .filter(|&n| is_needed[n])
                .collect(),
            rest: rest.collect::<Result<_>>()?,
        })
    }

    /// The motion, from the first key to the last; nothing where no bone is moved.
    fn clip(&self) -> Result<Option<MotionClip>> {
        let times = || self.tracks.iter().flat_map(|t| t.times.iter().copied());
        let (Some(start), Some(end)) = (times().reduce(f64::min), times().reduce(f64::max)) else {
            return Ok(None);
        };
        let fits = |rate: &&f64| {
            times().all(|t| {
                let frames = (t - start) * **rate;
                (frames - frames.round()).abs() < 1e-3
            })
        };
        let rate = RATES.iter().find(fits).copied().unwrap_or(120.0);
        let rate = rate * (LEAST_RATE / rate).ceil();
        let last = ((end - start) * rate - 1e-3).ceil().max(0.0);
        if (last + 1.0) * self.needed.len() as f64 > MOST_PLACEMENTS {
            let problem = format!(
                "{:.0} s are too long for so many nodes: split it",
                end - start
            );
            return Err(self.file.broken(&self.field, problem));
        }
        let poses: Vec<Vec<Frame>> = (0..=last as usize)
            .map(|k| self.pose(start + k as f64 / rate))
            .collect::<Result<_>>()?;
        let clip = self.away_from_rest(&poses, 1.0 / rate);
        clip.validate()?;
        Ok(Some(clip))
    }

    /// R and c of every bone at `time`.
    fn pose(&self, time: f64) -> Result<Vec<Frame>> {
        let mut local: BTreeMap<usize, Local> = BTreeMap::new();
        for track in &self.tracks {
            let local = local
                .entry(track.node)
                .or_insert(self.nodes.rest[track.node]);
            let value = track.sample(time);
            match track.property {
                Property::Translation => local.translation = value.truncate(),
                Property::Rotation => local.rotation = DQuat::from_vec4(value),
                Property::Scale => local.scale = value.truncate(),
            }
        }
        let mut world: Vec<DAffine3> = vec![DAffine3::IDENTITY; self.nodes.parents.len()];
        for &n in &self.needed {
            let own = local.get(&n).unwrap_or(&self.nodes.rest[n]).affine();
            world[n] = self.nodes.parents[n].map_or(own, |p| world[p] * own);
        }
        let frame = |(j, &n): (usize, &usize)| {
            let broken = |problem: &str| {
                let bone = name(self.file, n);
                let problem = format!("{}: at {time:.3} s bone {bone} {problem}", self.name);
                self.file.broken(&self.field, problem)
            };
            let now = similarity(world[n].matrix3).map_err(broken)?;
            let (rotation, scale) = self.rest[j];
            if !same_scale(now.scale, scale) {
                return Err(broken(
                    "changes its scale: bones are rigid, remove the scale's keys",
                ));
            }
            let rotation = now.rotation * rotation.transpose() * self.rig.rest[j].rotation;
            Ok(Frame {
                rotation,
                position: world[n].translation,
            })
        };
        self.rig.nodes.iter().enumerate().map(frame).collect()
    }

    fn away_from_rest(&self, poses: &[Vec<Frame>], frame_time: f64) -> MotionClip {
        let skeleton = &self.rig.skeleton;
        let (joints, parents) = (&skeleton.joints, &skeleton.parents);
        // t = R_pᵀ (c − c_p) − (J − J_p), of roots c − J.
        let shift = |pose: &[Frame], j: usize| match parents[j].map(|p| p as usize) {
            None => pose[j].position - joints[j],
            Some(p) => pose[p].inverse_transform(pose[j].position) - (joints[j] - joints[p]),
        };
        let turn = |pose: &[Frame], j: usize| {
            let above = parents[j].map_or(DMat3::IDENTITY, |p| pose[p as usize].rotation);
            DQuat::from_mat3(&(above.transpose() * pose[j].rotation)).normalize()
        };
        let (low, high) = (joints.iter())
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
                (low.min(*p), high.max(*p))
            });
        let still = (STILL[0] * (high - low).max_element()).min(STILL[1]);
        let moves = |&j: &usize| poses.iter().any(|p| shift(p, j).length() > still);
        let translated: Vec<usize> = (0..joints.len()).filter(moves).collect();
        let frame = |pose: &Vec<Frame>| MotionFrame {
            translations: translated.iter().map(|&j| shift(pose, j)).collect(),
            rotations: (0..joints.len()).map(|j| turn(pose, j)).collect(),
        };
        MotionClip {
            name: self.name.clone(),
            bones: skeleton.names.clone(),
            parents: parents.clone(),
            rest_joints: Some(joints.clone()),
            rest_up: UpAxis::Y,
            world_up: UpAxis::Y,
            frame_time,
            frames: poses.iter().map(frame).collect(),
            translated: translated.into_iter().map(|j| j as u32).collect(),
            notes: Vec::new(),
        }
    }
}
