//! Bones that carry nothing with mass: what drives the others carries them along.
//!
//! Hair and skirts that are merely drawn have bones of their own. They have no energy and no DoFs: each step they end
//! where their parents end, turned against them as the targets are (as pins are, the host's own), or else as they were.
//! Spring bones swing about there ([`super::spring_bones`]).

use super::instance::{Instance, SpringMode};
use crate::model::{Frame, Skeleton, State};
use crate::skeleton::SkeletonModel;
use glam::DVec3;

/// A carried bone in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct CarriedBone {
    pub bone: usize,
    pub parent: usize,
    /// Its frame in that of its parent; of a spring bone where it is at rest.
    pub local: Frame,
    /// Which of the asset's spring joints turns it.
    pub spring: Option<usize>,
}

impl CarriedBone {
    /// Where its parent has it.
    pub fn carried_by(&self, parent: &Frame) -> Frame {
        // Orthonormal again: products of many steps drift.
        parent.compose(&self.local).moved(DVec3::ZERO, DVec3::ZERO)
    }
}

/// The carried bones of `model` that no pin holds, parents first, into memory of the last step's. Where all spring bones
/// swing, pins of theirs and of what they carry say where they are at rest.
pub(super) fn carried_bones(
    model: &SkeletonModel,
    instance: &Instance,
    out: &mut Vec<CarriedBone>,
) {
    let (skeleton, joints): (&Skeleton, _) = (model.skeleton(), &model.springs().joints);
    let wanted = |bone: usize| {
        let pin = instance.pin_of(bone).map(|pin| pin.frame);
        pin.or_else(|| instance.target_of(bone).map(|target| target.frame))
    };
    let frames = &instance.state.frames;
    let mut next = 0;
    out.clear();
    for bone in model.carried() {
        while joints.get(next).is_some_and(|j| (j.bone as usize) < bone) {
            next += 1;
        }
        let swings = instance.springs != SpringMode::Off
            && joints.get(next).is_some_and(|j| j.bone as usize == bone);
        let Some(parent) = skeleton.parents[bone].map(|p| p as usize) else {
            continue;
        };
        let pinned = instance.pin_of(bone).is_some();
        let loose = || out.binary_search_by_key(&parent, |c| c.bone).is_ok();
        if pinned && !(instance.springs == SpringMode::All && (swings || loose())) {
            continue;
        }
        let local = match (wanted(parent), wanted(bone)) {
            (Some(outer), Some(inner)) => seen_from(&outer, &inner),
            _ if swings => Frame {
                rotation: joints[next].rest_rotation,
                position: skeleton.joints[bone] - skeleton.joints[parent],
            },
            _ => seen_from(&frames[parent], &frames[bone]),
        };
        out.push(CarriedBone {
            bone,
            parent,
            local,
            spring: swings.then_some(next),
        });
    }
}

/// The frame `inner` in that of `outer`.
fn seen_from(outer: &Frame, inner: &Frame) -> Frame {
    Frame {
        rotation: outer.rotation.transpose() * inner.rotation,
        position: outer.inverse_transform(inner.position),
    }
}

/// Puts the carried bones where their parents have them.
pub(super) fn carry(carried: &[CarriedBone], state: &mut State) {
    for of in carried {
        state.frames[of.bone] = of.carried_by(&state.frames[of.parent]);
    }
}
