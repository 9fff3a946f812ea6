//! The posed skin on the GPU.

use super::recorder::Recorder;
use super::shared::BatchState;
use super::stage::Stage;
use crate::gpu::Submission;
use crate::model::State;
use crate::potential::PreviousSkin;
use crate::{Error, Result};

impl Recorder {
    /// Positions and normals of every instance's skin with its `offsets`, if there are any, into the buffer that is drawn from.
    ///
    /// # Errors
    /// As [`Potential::pose_skin`](crate::potential::Potential::pose_skin); nothing is recorded then.
    pub fn record_pose_skin(
        &mut self,
        states: &[State],
        offsets: &[&[[f32; 3]]],
        previous: &[PreviousSkin],
        submission: &mut Submission,
    ) -> Result<()> {
        self.checks.poses(states, offsets, previous)?;
        let offsets_of = |i: usize| offsets.get(i).copied().unwrap_or_default();
        let (instances, sizes) = (self.starts.len(), self.buffers.sizes);
        let first = sizes.slots;
        self.clear_uploads();
        for (i, state) in states.iter().enumerate() {
            let batch_state = BatchState {
                instance: i as u32,
                slot: (first + i) as u32,
                has_offsets: u32::from(!offsets_of(i).is_empty()),
                ..BatchState::default()
            };
            if !self.push_state(batch_state, state, state, state.frames[0].position) {
                return Err(Error::NotFinite {
                    quantity: "state to be posed in f32",
                });
            }
            self.push_features(state);
        }
        self.upload_offsets((0..instances).map(|i| (i, offsets_of(i))), submission);
        let features = self.features.len() / instances;
        self.keep_skins(previous, PreviousSkin::Last, submission);
        for (i, state) in states.iter().enumerate() {
            self.skin_origins[i] = state.frames[0].position;
            self.posed_features[i].clear();
            let own = &self.features[i * features..(i + 1) * features];
            self.posed_features[i].extend_from_slice(own);
        }
        self.claim_poses(submission);
        self.upload_states(first);
        self.upload_batch(first);
        let batch = sizes.poses();
        self.dispatch(submission, |stages, pass| {
            stages.pose_blend.dispatch_posed_skin(pass, batch);
            stages.skin.dispatch(pass, batch);
            stages.normals.dispatch(pass, batch);
        });
        self.keep_skins(previous, PreviousSkin::New, submission);
        Ok(())
    }

    /// Makes what is posed the previous skin of the instances that `previous` has as `wanted`.
    fn keep_skins(
        &mut self,
        previous: &[PreviousSkin],
        wanted: PreviousSkin,
        submission: &mut Submission,
    ) {
        let common = &self.buffers.common;
        let (from, to) = (&common.skin_vertices, &common.previous_skin_vertices);
        let mut first = 0;
        // Neighbours go in one copy.
        for run in previous.chunk_by(|a, b| a == b) {
            let instances = first..first + run.len();
            first = instances.end;
            if run[0] == wanted {
                let (start, end) = (instances.start, instances.end - 1);
                let bytes = self.skin_range(start).start..self.skin_range(end).end;
                let (at, size) = (bytes.start, bytes.end - bytes.start);
                let encoder = submission.encoder();
                encoder.copy_buffer_to_buffer(from.raw(), at, to.raw(), at, size);
                self.previous_skin_origins[instances.clone()]
                    .copy_from_slice(&self.skin_origins[instances]);
            }
        }
    }
}
