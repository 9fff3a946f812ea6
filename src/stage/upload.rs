//! States into the form that kernels read: differences are taken in f64, then rounded.

use super::shared::{Collider, Frame, Handle, Mat3};
use super::tables::round;
use crate::collider;
use crate::model::{self, Skeleton, State};
use glam::{DMat3, DVec3};

fn columns(m: DMat3) -> Mat3 {
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

/// A collider at the end of the step, seen from `origin`.
pub(super) fn collider(collider: &collider::Collider, origin: DVec3) -> Collider {
    Collider {
        rotation: columns(collider.frame.rotation),
        position: round(collider.frame.position - origin),
        stiffness: collider.stiffness as f32,
        parameters: collider.shape.parameters(),
        margin: collider.margin as f32,
        shape: collider.shape.index(),
        ..Collider::default()
    }
}
