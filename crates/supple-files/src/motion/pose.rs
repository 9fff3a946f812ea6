//! What a source of motion says about its bones at one time.

use glam::{DQuat, DVec3};
use std::collections::BTreeMap;
use supple::model::UpAxis;

/// What is known of one bone, in the world of the source.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BonePose {
    /// Its rotation away from the rest pose.
    pub rotation: Option<DQuat>,
    /// Its joint's place, m.
    pub position: Option<DVec3>,
}

impl BonePose {
    /// Part of the way to `other`; what only one of them knows is kept.
    pub(super) fn towards(&self, other: &Self, part: f64) -> Self {
        Self {
            rotation: match (self.rotation, other.rotation) {
                (Some(a), Some(b)) => Some(a.slerp(b, part)),
                (a, b) => a.or(b),
            },
            position: match (self.position, other.position) {
                (Some(a), Some(b)) => Some(a.lerp(b, part)),
                (a, b) => a.or(b),
            },
        }
    }
}

/// Bones at one time, by name; what a hand tracker delivers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BonePoses {
    /// s.
    pub time: f64,
    /// What is known.
    pub bones: BTreeMap<String, BonePose>,
}

/// What a source of [`BonePoses`] says once, before all of them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PoseHeader {
    /// The axis that points up in its world; `None` if that is the world of the scene.
    pub up: Option<UpAxis>,
    /// The rest pose that rotations are away from: its joints' places, m, and the rotations that the
    /// source gives its bones in it. Empty if rotations are away from the avatar's bind pose.
    pub rest: BTreeMap<String, BonePose>,
}
