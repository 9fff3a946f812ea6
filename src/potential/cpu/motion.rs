//! A whole state seen from a base state.

use super::displacement::FrameMotion;
use crate::model::{Frame, State};
use glam::DVec3;

/// A state and its increments from a base, with frames relative to an origin near them.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// Frames of the state.
    pub frames: Vec<Frame>,
    /// Their rotations and increments.
    pub motions: Vec<FrameMotion>,
    /// φ of the state.
    pub handles: Vec<DVec3>,
    /// Δφ from the base.
    pub handle_changes: Vec<DVec3>,
}

impl Motion {
    /// Refills everything; allocates the first time only.
    pub fn set(&mut self, base: &State, state: &State, origin: DVec3) {
        let frames = base.frames.iter().zip(&state.frames);
        self.frames.clear();
        self.frames.extend(state.frames.iter().map(|f| Frame {
            position: f.position - origin,
            ..*f
        }));
        self.motions.clear();
        self.motions
            .extend(frames.map(|(base, state)| FrameMotion::new(base, state)));
        self.handles.clone_from(&state.handles);
        self.handle_changes.clear();
        let handles = base.handles.iter().zip(&state.handles);
        self.handle_changes
            .extend(handles.map(|(base, state)| *state - *base));
    }
}
