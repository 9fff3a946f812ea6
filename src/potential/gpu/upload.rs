//! What the next submission sends to the device.

use super::pack;
use super::potential::{GpuPotential, Start};
use super::shared::BatchState;
use crate::model::{State, pose_feature};
use crate::{Error, Result};
use glam::DVec3;

impl GpuPotential {
    pub(super) fn start(&self, instance: usize) -> Result<&Start> {
        (self.starts.get(instance))
            .and_then(Option::as_ref)
            .ok_or_else(|| {
                Error::invalid(
                    "instance",
                    format!("{instance} has not begun a step; call begin_step first"),
                )
            })
    }

    pub(super) fn clear_uploads(&mut self) {
        self.batch.clear();
        self.frames.clear();
        self.handles.clear();
        self.features.clear();
    }

    /// Appends a state to the uploads.
    pub(super) fn push_state(
        &mut self,
        batch_state: BatchState,
        base: &State,
        state: &State,
        origin: DVec3,
    ) {
        let skeleton = &self.avatar.skeleton;
        self.batch.push(batch_state);
        (self.frames).extend(pack::frames(skeleton, base, state, origin));
        self.handles.extend(pack::handles(base, state));
    }

    pub(super) fn push_features(&mut self, state: &State) {
        if self.buffers.common.pose_features.is_empty() {
            return;
        }
        let feature = pose_feature(&self.avatar.skeleton.parents, &state.frames);
        self.features.extend(feature.iter().map(|&f| f as f32));
    }

    /// Sends which frames are prescribed in each state of the batch.
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

    /// Sends the uploads; states go to consecutive slots from `slot` on.
    pub(super) fn upload(&self, slot: usize) {
        let (space, buffers) = (self.avatar.space(), &self.buffers.common);
        buffers.batch.write(&self.queue, 0, &self.batch);
        (buffers.frames).write(&self.queue, slot * space.frames, &self.frames);
        (buffers.handles).write(&self.queue, slot * space.handles, &self.handles);
    }
}
