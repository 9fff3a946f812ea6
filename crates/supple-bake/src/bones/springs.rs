//! Which of a file's spring bones swing.

use serde::{Deserialize, Serialize};
use supple::model::{Avatar, SpringBones};

/// How much swings by a file's spring bones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SpringReport {
    /// Chains.
    pub chains: usize,
    /// Joints of all chains.
    pub joints: usize,
    /// Spheres and capsules that they collide with.
    pub colliders: usize,
}

impl SpringReport {
    /// Of `springs`.
    pub fn of(springs: &SpringBones) -> Self {
        Self {
            chains: springs.chains.len(),
            joints: springs.joints.len(),
            colliders: springs.colliders.len(),
        }
    }
}

impl std::fmt::Display for SpringReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            chains,
            joints,
            colliders,
        } = self;
        write!(f, "{chains} chains, {joints} joints, {colliders} colliders")
    }
}

/// Takes the spring bones out that move tissue, or are above one that does: it swings of itself, and their motion would
/// come on top. Tells which, where there are any.
pub(crate) fn left_to_tissue(avatar: &mut Avatar) -> Option<String> {
    const MOST: usize = 4;
    let mut springs = std::mem::take(&mut avatar.springs);
    let mut names: Vec<&str> = Vec::new();
    springs.retain_joints(|joint| {
        let bone = joint.bone as usize;
        let keep = avatar.is_carried(bone);
        if !keep {
            names.push(&avatar.skeleton.names[bone]);
        }
        keep
    });
    let count = names.len();
    let mut told = names[..count.min(MOST)].join(", ");
    if count > MOST {
        told += &format!(" and {} more", count - MOST);
    }
    avatar.springs = springs;
    (count > 0).then(|| {
        format!("spring bones that move tissue do not swing, since tissue does of itself: {told}")
    })
}
