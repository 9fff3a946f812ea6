//! What the next submission sends to the device.

use super::pack;
use super::recorder::{Recorder, Start};
use super::shared::BatchState;
use crate::model::{State, pose_feature};
use crate::potential::StepStart;
use crate::{Error, Result};
use bytemuck::Pod;
use glam::DVec3;

/// Longest that any number of a frame may be, m: beyond it f32 would not hold what comes of it.
const LONGEST_FRAME: f32 = 1e9;

impl Recorder {
    pub(super) fn clear_uploads(&mut self) {
        self.batch.clear();
        self.frames.clear();
        self.handles.clear();
        self.past_frames.clear();
        self.past_handles.clear();
        self.features.clear();
    }

    /// Appends a state to the uploads; false where it had to be cut to what f32 can compute with. The kernels' language
    /// promises nothing of numbers that overflow, not even that they are infinite.
    pub(super) fn push_state(
        &mut self,
        batch_state: BatchState,
        base: &State,
        state: &State,
        origin: DVec3,
    ) -> bool {
        let (first_frame, first_handle) = (self.frames.len(), self.handles.len());
        let skeleton = &self.avatar.skeleton;
        self.batch.push(batch_state);
        (self.frames).extend(pack::frames(skeleton, base, state, origin));
        self.handles.extend(pack::handles(base, state));
        let frames = cut(&mut self.frames[first_frame..], LONGEST_FRAME);
        frames & cut(&mut self.handles[first_handle..], self.longest_handle)
    }

    /// Appends the start of a step, likewise.
    pub(super) fn push_start(
        &mut self,
        batch_state: BatchState,
        start: &StepStart<'_>,
        origin: DVec3,
    ) -> bool {
        let (current, target) = (start.current, &start.inertia);
        let (first_frame, first_handle) = (self.frames.len(), self.handles.len());
        let (past_frame, past_handle) = (self.past_frames.len(), self.past_handles.len());
        let skeleton = &self.avatar.skeleton;
        self.batch.push(batch_state);
        (self.frames).extend(pack::frames(skeleton, current, current, origin));
        (self.handles).extend(pack::start_handles(target, current));
        (self.past_frames).extend(pack::past_frames(target, current));
        (self.past_handles).extend(pack::past_handles(target, current));
        let frames = cut(&mut self.frames[first_frame..], LONGEST_FRAME)
            & cut(&mut self.past_frames[past_frame..], LONGEST_FRAME);
        let handles = cut(&mut self.handles[first_handle..], self.longest_handle)
            & cut(&mut self.past_handles[past_handle..], LONGEST_FRAME);
        frames & handles
    }

    /// Fills the uploads with every wanted state, each measured from its instance's start and in a slot behind the starts'.
    /// What was recorded before is not read any more.
    pub(super) fn push_states(&mut self, states: &[State], wanted: &[bool]) -> Result<()> {
        self.results = 0..0;
        let begun = |i: usize| self.starts[i].is_some();
        (self.checks).states(states, wanted, self.starts.len(), begun)?;
        self.clear_uploads();
        for (i, state) in states.iter().enumerate().filter(|(i, _)| wanted[*i]) {
            self.push_from_start(i, state)?;
        }
        Ok(())
    }

    /// [`Recorder::push_states`] of one alone.
    pub(super) fn push_one_state(&mut self, instance: usize, state: &State) -> Result<()> {
        self.results = 0..0;
        self.checks.instance(instance)?;
        self.checks.state(state)?;
        self.clear_uploads();
        self.push_from_start(instance, state)
    }

    /// Appends a state of instance `i`, measured from its start.
    fn push_from_start(&mut self, i: usize, state: &State) -> Result<()> {
        let Start {
            origin,
            current,
            batch_state,
            ..
        } = self.start(i)?.clone();
        let batch_state = BatchState {
            slot: (self.starts.len() + self.batch.len()) as u32,
            base: i as u32,
            ..batch_state
        };
        if !self.push_state(batch_state, &current, state, origin) {
            let quantity = "state in f32";
            return Err(Error::NotFinite { quantity });
        }
        Ok(())
    }

    pub(super) fn push_features(&mut self, state: &State) {
        if self.buffers.common.pose_features.is_empty() {
            return;
        }
        let feature = pose_feature(&self.avatar.skeleton.parents, &state.frames);
        self.features.extend(feature.iter().map(|&f| f as f32));
    }

    /// Sends which frames are prescribed in each state of the batch; belongs to the states' part of the uploads.
    pub(super) fn upload_prescribed(&mut self) {
        if !self.has_prescribed {
            return;
        }
        let words = self.buffers.sizes.frame_words;
        self.prescribed.clear();
        for state in &self.batch {
            let first = self.prescribed.len();
            self.prescribed.resize(first + words, 0);
            let start = self.starts[state.instance as usize].as_ref();
            let prescribed = start.map_or(&[][..], |start| &start.prescribed);
            for (frame, prescribed) in prescribed.iter().enumerate() {
                self.prescribed[first + frame / 32] |= u32::from(*prescribed) << (frame % 32);
            }
        }
        (self.buffers.common.prescribed).write(&self.queue, 0, &self.prescribed);
    }

    /// Sends frames and handles to consecutive slots from `slot` on.
    pub(super) fn upload_states(&self, slot: usize) {
        let (space, buffers) = (self.avatar.space(), &self.buffers.common);
        (buffers.frames).write(&self.queue, slot * space.frames, &self.frames);
        (buffers.handles).write(&self.queue, slot * space.handles, &self.handles);
    }

    /// Sends the batch, its first state to place `first`, and its pose features.
    pub(super) fn upload_batch(&self, first: usize) {
        let buffers = &self.buffers.common;
        buffers.batch.write(&self.queue, first, &self.batch);
        let first = first * self.buffers.sizes.features;
        (buffers.pose_features).write(&self.queue, first, &self.features);
    }
}

/// Cuts all numbers of `items`, which hold f32 and zeros, to `longest`; whether nothing was cut.
fn cut(items: &mut [impl Pod], longest: f32) -> bool {
    let mut whole = true;
    for x in bytemuck::cast_slice_mut::<_, f32>(items) {
        whole &= x.abs() <= longest;
        *x = x.clamp(-longest, longest);
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_long_is_cut_and_told() {
        let mut items = [[1.0f32, -2.0], [0.0, 2.0]];
        assert!(cut(&mut items, 2.0));
        assert_eq!(items, [[1.0, -2.0], [0.0, 2.0]]);
        assert!(!cut(&mut items, 1.5));
        assert_eq!(items, [[1.0, -1.5], [0.0, 1.5]]);
        let mut items = [f32::INFINITY, f32::NEG_INFINITY];
        assert!(!cut(&mut items, 3.0));
        assert_eq!(items, [3.0, -3.0]);
    }
}
