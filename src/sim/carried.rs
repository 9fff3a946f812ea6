//! Bones that carry nothing with mass: what drives the others carries them along.
//!
//! Hair and skirts that are merely drawn have bones of their own. They have no energy and no DoFs: each step they end
//! where their parents end, turned against them as the targets are (as pins are, the host's own), or else as they were.

use super::instance::Instance;
use crate::model::{Frame, Skeleton, State};
use crate::skeleton::SkeletonModel;
use glam::DVec3;

/// A carried bone in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct CarriedBone {
    pub bone: usize,
    parent: usize,
    /// Its frame in that of its parent.
    local: Frame,
}

/// The carried bones of `model` that no pin holds, parents first, into memory of the last step's.
pub(super) fn carried_bones(
    model: &SkeletonModel,
    instance: &Instance,
    out: &mut Vec<CarriedBone>,
) {
    let skeleton: &Skeleton = model.skeleton();
    let pinned = |bone: usize| instance.pins.iter().find(|pin| pin.bone == bone);
    let wanted = |bone: usize| {
        let target = || instance.targets.iter().find(|t| t.bone == bone);
        let pin = pinned(bone).map(|pin| pin.frame);
        pin.or_else(|| target().map(|target| target.frame))
    };
    out.clear();
    for bone in model.carried().filter(|&bone| pinned(bone).is_none()) {
        let Some(parent) = skeleton.parents[bone].map(|p| p as usize) else {
            continue;
        };
        let frames = &instance.state.frames;
        let (outer, inner) = match (wanted(parent), wanted(bone)) {
            (Some(outer), Some(inner)) => (outer, inner),
            _ => (frames[parent], frames[bone]),
        };
        let local = Frame {
            rotation: outer.rotation.transpose() * inner.rotation,
            position: outer.inverse_transform(inner.position),
        };
        out.push(CarriedBone {
            bone,
            parent,
            local,
        });
    }
}

/// Puts the carried bones where their parents have them.
pub(super) fn carry(carried: &[CarriedBone], state: &mut State) {
    for of in carried {
        let frame = state.frames[of.parent].compose(&of.local);
        // Orthonormal again: products of many steps drift.
        state.frames[of.bone] = frame.moved(DVec3::ZERO, DVec3::ZERO);
    }
}
