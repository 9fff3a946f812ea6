//! States into the form that kernels read: differences are taken in f64, then rounded.

use super::potential::{GpuPotential, Start};
use super::shared::{BatchState, Collider, Frame, Handle, Mat3};
use super::tables::round;
use crate::collider::{self, Shape};
use crate::model::{self, Skeleton, State, pose_feature};
use crate::{Error, Result};
use glam::{DMat3, DVec3};

pub(super) fn columns(m: DMat3) -> Mat3 {
    let m = m.as_mat3();
    [m.x_axis, m.y_axis, m.z_axis].map(|c| c.extend(0.0).to_array())
}

/// Frames of `state` relative to `origin`, with their increments from `base`.
fn frames<'a>(
    skeleton: &'a Skeleton,
    base: &'a State,
    state: &'a State,
    origin: DVec3,
) -> impl Iterator<Item = Frame> + 'a {
    let frame = move |((b, s), &joint): ((&model::Frame, &model::Frame), &DVec3)| Frame {
        rotation: columns(s.rotation),
        rotation_increment: columns(s.rotation - b.rotation),
        position: round(s.position - origin),
        position_increment: round(s.position - b.position),
        joint: round(joint),
        ..Frame::default()
    };
    (base.frames.iter())
        .zip(&state.frames)
        .zip(&skeleton.joints)
        .map(frame)
}

/// Handles of `base` with their increments to `state`.
fn handles<'a>(base: &'a State, state: &'a State) -> impl Iterator<Item = Handle> + 'a {
    (base.handles.iter())
        .zip(&state.handles)
        .map(|(b, s)| Handle {
            displacement: round(*b),
            increment: round(*s - *b),
            ..Handle::default()
        })
}

/// A collider at the end of the step or, else, at its start, seen from `origin`. The frame of a mesh is moved to the
/// first node of its grid, which is in `slot`.
pub(super) fn collider(
    collider: &collider::Collider,
    origin: DVec3,
    end: bool,
    slot: usize,
) -> Collider {
    let mut parameters = collider.shape.parameters();
    let mut first = DVec3::ZERO;
    if let Shape::Mesh(mesh) = &collider.shape {
        first = mesh.grid().low();
        parameters[3] = slot as f32;
    }
    let seen = collider.relative_to(origin);
    let at_first = |frame: model::Frame| model::Frame {
        position: frame.transform(first),
        ..frame
    };
    // What is carried stands in its body's frame all the time.
    let still = collider.body.is_some();
    let frame = at_first(seen.frame);
    let previous = if still {
        frame
    } else {
        at_first(seen.previous)
    };
    let place = if end { frame } else { previous };
    Collider {
        rotation: columns(place.rotation),
        position: round(place.position),
        stiffness: collider.stiffness as f32,
        parameters,
        margin: collider.margin as f32,
        shape: collider.shape.index(),
        friction: collider.friction as f32,
        body: collider.body.map_or(0, |frame| frame + 1),
        rotation_change: columns(frame.rotation - previous.rotation),
        position_change: round(frame.position - previous.position),
        ..Collider::default()
    }
}

impl GpuPotential {
    pub(super) fn check_length(&self, field: &str, length: usize) -> Result<()> {
        let instances = self.starts.len();
        if length == instances {
            return Ok(());
        }
        Err(Error::invalid(
            field,
            format!("{length} given for {instances} instances"),
        ))
    }

    pub(super) fn check_state(&self, state: &State) -> Result<()> {
        if state.space() != self.avatar.space() {
            return Err(Error::invalid("state", "is of another avatar"));
        }
        if !state.is_finite() {
            return Err(Error::NotFinite { quantity: "state" });
        }
        Ok(())
    }

    pub(super) fn start(&self, instance: usize) -> Result<&Start> {
        (self.starts.get(instance))
            .and_then(Option::as_ref)
            .ok_or_else(|| {
                Error::invalid(
                    "instance",
                    format!("{instance} has not begun a step; call begin_step first"),
                )
            })
    }

    pub(super) fn clear_uploads(&mut self) {
        self.batch.clear();
        self.frames.clear();
        self.handles.clear();
        self.features.clear();
    }

    /// Appends a state to the uploads.
    pub(super) fn push(&mut self, header: BatchState, base: &State, state: &State, origin: DVec3) {
        let skeleton = &self.avatar.skeleton;
        self.batch.push(header);
        (self.frames).extend(frames(skeleton, base, state, origin));
        self.handles.extend(handles(base, state));
    }

    pub(super) fn push_features(&mut self, state: &State) {
        if self.buffers.features.is_empty() {
            return;
        }
        let feature = pose_feature(&self.avatar.skeleton.parents, &state.frames);
        self.features.extend(feature.iter().map(|&f| f as f32));
    }

    /// Sends the uploads; states go to consecutive slots from `slot` on.
    pub(super) fn upload(&self, slot: usize) {
        let space = self.avatar.space();
        self.buffers.batch.write(&self.queue, 0, &self.batch);
        (self.buffers.frames).write(&self.queue, slot * space.frames, &self.frames);
        (self.buffers.handles).write(&self.queue, slot * space.handles, &self.handles);
    }
}
