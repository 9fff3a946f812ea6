//! Numbers into the form that kernels read: differences are taken in f64, then rounded.

use super::shared::{Collider, Frame, Handle, Mat3, PastFrame, PastHandle};
use crate::collider::{self, Shape};
use crate::model::{self, InertialTarget, Skeleton, State};
use glam::{DMat3, DVec3};

pub(super) fn round(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

pub(super) fn columns(m: DMat3) -> Mat3 {
    let m = m.as_mat3();
    [m.x_axis, m.y_axis, m.z_axis].map(|c| c.extend(0.0).to_array())
}

/// Frames of `state` relative to `origin`, with their increments from `base`.
pub(super) fn frames<'a>(
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

/// What inertia takes from the past of frames that stand at `current`.
pub(super) fn past_frames<'a>(
    target: &'a InertialTarget<'a>,
    current: &'a State,
) -> impl Iterator<Item = PastFrame> + 'a {
    current.frames.iter().enumerate().map(|(j, frame)| {
        let (turn, shift) = target.frame(j, frame);
        let mut past = target.terms().map(|(_, past)| past.frames[j].rotation);
        let mut next = || past.next().map_or(Mat3::default(), columns);
        PastFrame {
            turn: columns(turn),
            first: next(),
            second: next(),
            third: next(),
            shift: round(shift),
            ..PastFrame::default()
        }
    })
}

/// What inertia takes from the past of handles that stand at `current`.
pub(super) fn past_handles<'a>(
    target: &'a InertialTarget<'a>,
    current: &'a State,
) -> impl Iterator<Item = PastHandle> + 'a {
    current.handles.iter().enumerate().map(|(h, phi)| {
        let mut past = target.terms().map(|(c, past)| (past.handles[h] - *phi) * c);
        let mut next = || past.next().map_or([0.0; 3], round);
        PastHandle {
            first: next(),
            second: next(),
            third: next(),
            ..PastHandle::default()
        }
    })
}

/// Handles of a start, whose increment is the drift of damping.
pub(super) fn start_handles<'a>(
    target: &'a InertialTarget<'a>,
    current: &'a State,
) -> impl Iterator<Item = Handle> + 'a {
    current.handles.iter().enumerate().map(|(h, phi)| {
        let drift = target.handle_drift(h, *phi);
        Handle {
            displacement: round(*phi - drift),
            increment: round(drift),
            ..Handle::default()
        }
    })
}

/// Handles of `base` with their increments to `state`.
pub(super) fn handles<'a>(base: &'a State, state: &'a State) -> impl Iterator<Item = Handle> + 'a {
    (base.handles.iter())
        .zip(&state.handles)
        .map(|(b, s)| Handle {
            displacement: round(*b),
            increment: round(*s - *b),
            ..Handle::default()
        })
}

/// A collider at the end of the step or, else, at its start, seen from `origin`, its μ times `friction`. The frame of a mesh is moved to the
/// first node of its grid, the `grid`th on the device.
pub(super) fn collider(
    collider: &collider::Collider,
    friction: f64,
    origin: DVec3,
    end: bool,
    grid: usize,
) -> Collider {
    let mut parameters = collider.shape.parameters();
    let mut first = DVec3::ZERO;
    if let Shape::Mesh(mesh) = &collider.shape {
        first = mesh.grid().low();
        parameters[3] = grid as f32;
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
        stiffness: collider.stiffness.unwrap_or(0.0) as f32,
        parameters,
        margin: collider.margin as f32,
        shape: collider.shape.index(),
        friction: (friction * collider.friction) as f32,
        body: collider.body.map_or(0, |frame| frame + 1),
        rotation_change: columns(frame.rotation - previous.rotation),
        position_change: round(frame.position - previous.position),
        ..Collider::default()
    }
}
