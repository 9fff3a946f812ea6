//! What the waking of fine handles remembers of an instance from frame to frame.

/// A handle that is near something, scratch of a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    pub handle: u32,
    /// To the nearest collider, m; negative inside.
    pub distance: f64,
}

/// What an instance remembers between frames besides what is awake, and scratch.
#[derive(Clone, Debug, Default)]
pub(crate) struct WakingMemory {
    pub(super) near: Vec<Near>,
    /// Of each slot that is taken, whether its φ is being taken back.
    pub(super) leaving: Vec<bool>,
    pub(super) distances: Vec<f64>,
}

impl WakingMemory {
    /// Whether φ of a slot is prescribed in the next step.
    pub fn is_leaving(&self, slot: usize) -> bool {
        self.leaving.get(slot).is_some_and(|l| *l)
    }
}
