//! The reduced coordinates q = (c, R of every bone; φ of every handle).

use super::Frame;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// How the degrees of freedom of one avatar are numbered.
///
/// DoFs come in 3-vectors called blocks: block `2j` is δc of bone `j`, block `2j + 1` its δω, and
/// block `2·frames + h` is δφ of handle `h`. DoF `3·block + axis` is the scalar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Space {
    /// Rigid frames that move with the system (bones).
    pub frames: usize,
    /// Handles of the soft tissue.
    pub handles: usize,
}

impl Space {
    /// Number of 3-vectors.
    pub fn blocks(&self) -> usize {
        2 * self.frames + self.handles
    }

    /// Number of scalars.
    pub fn dofs(&self) -> usize {
        3 * self.blocks()
    }

    /// Block of the translation of frame `j`; its rotation is the next one.
    pub fn frame_block(&self, j: usize) -> usize {
        2 * j
    }

    /// Block of handle `h`.
    pub fn handle_block(&self, h: usize) -> usize {
        2 * self.frames + h
    }
}

/// One configuration of an avatar, in f64 and world space.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Bones: rotation from the bind pose and joint position.
    pub frames: Vec<Frame>,
    /// Handle displacements φ in unposed space, m; those of the slots for fine handles are the last
    /// ([`Avatar::with_fine_slots`](super::Avatar::with_fine_slots)).
    pub handles: Vec<DVec3>,
    /// The fine handle that each slot stands for, of those that are taken.
    #[serde(skip)]
    pub awake: Vec<u32>,
}

impl Clone for State {
    fn clone(&self) -> Self {
        // With the room that a step may need.
        let mut awake = Vec::with_capacity(self.awake.capacity());
        awake.extend(&self.awake);
        Self {
            frames: self.frames.clone(),
            handles: self.handles.clone(),
            awake,
        }
    }

    /// In the memory that is there, as a step needs it: a derived one would allocate.
    fn clone_from(&mut self, other: &Self) {
        self.frames.clone_from(&other.frames);
        self.handles.clone_from(&other.handles);
        self.awake.clone_from(&other.awake);
    }
}

impl State {
    /// The numbering of this state's DoFs.
    pub fn space(&self) -> Space {
        Space {
            frames: self.frames.len(),
            handles: self.handles.len(),
        }
    }

    /// The state moved by `scale · step`, `step` holding [`Space::dofs`] scalars in block order:
    /// c += δc, R ← exp(\[δω\]) R, φ += δφ.
    pub fn moved(&self, step: &[f64], scale: f64) -> Self {
        let mut out = self.clone();
        out.move_by(step, scale);
        out
    }

    /// [`State::moved`] in place.
    pub fn move_by(&mut self, step: &[f64], scale: f64) {
        let block = |b: usize| DVec3::from_slice(&step[3 * b..3 * b + 3]) * scale;
        for (j, frame) in self.frames.iter_mut().enumerate() {
            *frame = frame.moved(block(2 * j), block(2 * j + 1));
        }
        let first = 2 * self.frames.len();
        for (h, handle) in self.handles.iter_mut().enumerate() {
            *handle += block(first + h);
        }
    }

    /// The step with `self.moved(step, 1.0)` = `other`.
    pub fn step_to(&self, other: &Self) -> Vec<f64> {
        let frames = self.frames.iter().zip(&other.frames).flat_map(|(a, b)| {
            let (translation, rotation) = a.motion_to(b);
            [translation, rotation]
        });
        let handles = self
            .handles
            .iter()
            .zip(&other.handles)
            .map(|(a, b)| *b - *a);
        frames.chain(handles).flat_map(|v| v.to_array()).collect()
    }

    /// Moves to `ratio` times the distance from `origin`, along the step that leads here from there.
    pub(crate) fn stretch_from(&mut self, origin: &Self, ratio: f64) {
        for (frame, start) in self.frames.iter_mut().zip(&origin.frames) {
            let (translation, rotation) = frame.motion_to(start);
            *frame = start.moved(-ratio * translation, -ratio * rotation);
        }
        for (handle, start) in self.handles.iter_mut().zip(&origin.handles) {
            *handle = *start - (*start - *handle) * ratio;
        }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.frames
            .iter()
            .all(|f| f.position.is_finite() && f.rotation.is_finite())
            && self.handles.iter().all(|h| h.is_finite())
    }
}
