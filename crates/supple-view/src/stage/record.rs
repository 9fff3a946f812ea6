//! What happened in the last seconds, to be written as GLB.

use std::path::Path;
use supple::Result;
use supple::model::{Avatar, State, UpAxis};
use supple_files::{GlbReport, Recording, write_glb};

/// s.
const KEPT: f64 = 20.0;
/// From one state to the next, s.
const EVERY: f64 = 1.0 / 30.0;

/// The last seconds of a character.
#[derive(Clone, Debug)]
pub struct Record {
    recording: Recording,
}

impl Record {
    /// Nothing yet, in a world where `up` points up.
    pub fn new(up: UpAxis) -> Self {
        Self {
            recording: Recording {
                up,
                ..Recording::default()
            },
        }
    }

    /// Adds a state, whose first `bones` frames are the character's, thirty times a second.
    pub fn add(&mut self, time: f64, state: &State, bones: usize) {
        let Recording { times, states, .. } = &mut self.recording;
        if times.last().is_some_and(|last| time < last + EVERY - 1e-9) {
            return;
        }
        let old = times.partition_point(|t| *t < time - KEPT);
        times.drain(..old);
        states.drain(..old);
        times.push(time);
        states.push(State {
            frames: state.frames[..bones].to_vec(),
            handles: state.handles.clone(),
            awake: state.awake.clone(),
        });
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.recording.times.clear();
        self.recording.states.clear();
    }

    /// Whether nothing has happened.
    pub fn is_empty(&self) -> bool {
        self.recording.times.is_empty()
    }

    /// Writes it as a GLB file that any viewer plays, its times from 0 on.
    ///
    /// # Errors
    /// [`supple::Error::Io`], and that nothing has happened yet.
    pub fn write_glb(&self, avatar: &Avatar, path: &Path) -> Result<GlbReport> {
        let mut recording = self.recording.clone();
        let first = recording.times.first().copied().unwrap_or(0.0);
        recording.times.iter_mut().for_each(|t| *t -= first);
        write_glb(avatar, &recording, path)
    }
}
