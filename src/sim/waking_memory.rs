//! What the waking of fine handles remembers of an instance from frame to frame.

use serde::{Deserialize, Serialize};

/// A handle that is near something, scratch of a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    pub handle: u32,
    /// To the nearest collider, m; negative inside.
    pub distance: f64,
}

/// What an instance remembers between frames besides what is awake, and scratch.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct WakingMemory {
    #[serde(skip)]
    pub(super) near: Vec<Near>,
    /// Of each slot that is taken, whether its φ is being taken back.
    pub(super) leaving: Vec<bool>,
    #[serde(skip)]
    pub(super) distances: Vec<f64>,
    /// The fine handle that makes room for another, though something is near.
    pub(super) eased_out: Option<u32>,
}

impl WakingMemory {
    /// Whether φ of a slot is prescribed in the next step.
    pub fn is_leaving(&self, slot: usize) -> bool {
        self.leaving.get(slot).is_some_and(|l| *l)
    }
}
