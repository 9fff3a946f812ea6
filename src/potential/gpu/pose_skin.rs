//! The posed skin on the GPU.

use super::dispatch::Batch;
use super::recorder::Recorder;
use super::shared::BatchState;
use super::stage::Stage;
use crate::gpu::Submission;
use crate::model::State;
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
        submission: &mut Submission,
    ) -> Result<()> {
        self.checks.poses(states, offsets)?;
        let offsets_of = |i: usize| offsets.get(i).copied().unwrap_or_default();
        let instances = self.starts.len();
        self.clear_uploads();
        for (i, state) in states.iter().enumerate() {
            let batch_state = BatchState {
                instance: i as u32,
                slot: (instances + i) as u32,
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
        for (i, state) in states.iter().enumerate() {
            self.skin_origins[i] = state.frames[0].position;
            self.posed_features[i].clear();
            let own = &self.features[i * features..(i + 1) * features];
            self.posed_features[i].extend_from_slice(own);
        }
        self.claim_states(submission);
        self.upload_states(instances);
        self.upload_batch(0);
        let batch = Batch::whole(instances);
        self.dispatch(submission, |stages, pass| {
            stages.pose_blend.dispatch_posed_skin(pass, batch);
            stages.skin.dispatch(pass, batch);
            stages.normals.dispatch(pass, batch);
        });
        Ok(())
    }
}
