//! Animations as motions of the bones, away from the reference shape.
//!
//! Bones are rigid: keys of scales are left out, with a note, and every node keeps the scale that it has at rest.

use super::container::File;
use super::document::Animation;
use super::motion_bones::MotionBones;
use super::nodes::{Local, Nodes};
use super::rig::name;
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

/// A scale's keys this near to its value at rest, relative to that, are rounding and not worth a word.
const ROUNDING: f64 = 1e-4;

/// Bones whose scales a note tells one by one.
const MOST_NAMED: usize = 8;

/// The motions of a file; animations that have keys for no bone are left out.
pub(super) fn motions(file: &File, nodes: &Nodes, bones: &MotionBones) -> Result<Vec<MotionClip>> {
    let mut clips = Vec::new();
    for (i, animation) in file.document.animations.iter().enumerate() {
        let field = format!("animations[{i}]");
        clips.extend(Player::new(file, nodes, bones, animation, field)?.clip()?);
    }
    Ok(clips)
}

struct Player<'a> {
    file: &'a File,
    nodes: &'a Nodes,
    bones: &'a MotionBones,
    field: String,
    name: String,
    tracks: Vec<Track>,
    /// Bones and what is above them, parents first.
    needed: Vec<usize>,
}

impl<'a> Player<'a> {
    fn new(
        file: &'a File,
        nodes: &'a Nodes,
        bones: &'a MotionBones,
        animation: &Animation,
        field: String,
    ) -> Result<Self> {
        let mut is_needed = vec![false; nodes.parents.len()];
        bones.nodes.iter().for_each(|&n| is_needed[n] = true);
        for &n in nodes.order.iter().rev() {
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
        Ok(Self {
            file,
            nodes,
            bones,
            name: animation.name.clone().unwrap_or_else(|| field.clone()),
            field,
            tracks,
            needed: nodes
                .order
                .iter()
                .copied()
                .filter(|&n| is_needed[n])
                .collect(),
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
            .collect();
        let clip = self.away_from_rest(&poses, 1.0 / rate);
        clip.validate()?;
        Ok(Some(clip))
    }

    /// R and c of every bone at `time`: with Q the rotation of its node, R(t) = Q(t) Qᵀ R_rest.
    fn pose(&self, time: f64) -> Vec<Frame> {
        let nodes = self.nodes;
        let mut moved: BTreeMap<usize, Local> = BTreeMap::new();
        for track in &self.tracks {
            let local = moved.entry(track.node).or_insert(nodes.rest[track.node]);
            let value = track.sample(time);
            match track.property {
                Property::Translation => local.translation = value.truncate(),
                Property::Rotation => local.rotation = DQuat::from_vec4(value),
                Property::Scale => {}
            }
        }
        let mut world: Vec<DAffine3> = vec![DAffine3::IDENTITY; nodes.parents.len()];
        let mut rotations: Vec<DMat3> = vec![DMat3::IDENTITY; nodes.parents.len()];
        for &n in &self.needed {
            let local = moved.get(&n).unwrap_or(&nodes.rest[n]);
            world[n] = nodes.parents[n].map_or(local.affine(), |p| world[p] * local.affine());
            rotations[n] = nodes.turned(n, local, &world, &rotations);
        }
        let frame = |(&n, rest): (&usize, &Frame)| Frame {
            rotation: rotations[n] * nodes.rest_rotation[n].transpose() * rest.rotation,
            position: world[n].translation,
        };
        self.bones
            .nodes
            .iter()
            .zip(&self.bones.rest)
            .map(frame)
            .collect()
    }

    /// The keys of scales that are left out, with their bones and ranges.
    fn notes(&self) -> Vec<String> {
        let mut bones: Vec<String> = Vec::new();
        for track in self.tracks.iter().filter(|t| t.property == Property::Scale) {
            let rest = self.nodes.rest[track.node].scale;
            if track.farthest_from(rest) > ROUNDING * rest.abs().max_element() {
                let (least, greatest) = track.range();
                let name = name(self.file, track.node);
                bones.push(format!("{name} ({least:.3} to {greatest:.3})"));
            }
        }
        let others = bones.len().saturating_sub(MOST_NAMED);
        bones.truncate(MOST_NAMED);
        if others > 0 {
            bones.push(format!("and {others} others"));
        }
        let note = format!(
            "clip {}: keys of scales are left out, since bones are rigid: {}",
            self.name,
            bones.join(", ")
        );
        (!bones.is_empty()).then_some(note).into_iter().collect()
    }

    fn away_from_rest(&self, poses: &[Vec<Frame>], frame_time: f64) -> MotionClip {
        let (joints, parents) = (&self.bones.joints, &self.bones.parents);
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
            bones: self.bones.names.clone(),
            parents: parents.clone(),
            rest_joints: Some(joints.clone()),
            rest_up: UpAxis::Y,
            world_up: UpAxis::Y,
            frame_time,
            frames: poses.iter().map(frame).collect(),
            translated: translated.into_iter().map(|j| j as u32).collect(),
            notes: self.notes(),
        }
    }
}
