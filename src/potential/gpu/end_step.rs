//! What the state at a step's end tells, on the GPU: the stages of an evaluation without those that only the handles'
//! derivatives need. It reads back some hundred bytes a frame.

use super::evaluate::{energies, float, is_sound};
use super::recorder::{Recorder, part};
use super::shared::Summary;
use super::stage::Stage;
use crate::gpu::Submission;
use crate::model::State;
use crate::potential::StepEnd;
use crate::{Error, Result};
use glam::Vec3;

impl Recorder {
    /// Every wanted state, from its instance's start.
    ///
    /// # Errors
    /// As [`Potential::end_step`](crate::potential::Potential::end_step), and [`crate::GpuError::Limit`] where the
    /// submission has no room to read it back; nothing is recorded then.
    pub fn record_end_step(
        &mut self,
        states: &[State],
        wanted: &[bool],
        submission: &mut Submission,
    ) -> Result<()> {
        self.ends = 0..0;
        self.push_states(states, wanted)?;
        self.ended.clear();
        self.ended.extend(self.batch.iter().map(|s| s.instance));
        let count = self.batch.len();
        if count == 0 {
            return Ok(());
        }
        let summary_bytes = (count * size_of::<Summary>()) as u64;
        let gradient_bytes = self.buffers.sizes.frame_gradient_bytes() as u64;
        let room = submission.reserve(summary_bytes + count as u64 * gradient_bytes)?;
        self.ends = room.start as usize..room.end as usize;
        self.claim_states(submission);
        self.upload_states(self.starts.len());
        self.upload_batch(0);
        for batch in self.chunks(count) {
            self.dispatch(submission, |stages, pass| {
                stages.displacement.dispatch(pass, batch);
                stages.contact.dispatch(pass, batch);
                if self.has_friction {
                    stages.friction.dispatch(pass, batch);
                }
                stages.compact.dispatch(pass, batch);
                stages.gradient.dispatch_frames(pass, batch);
                stages.energy.dispatch(pass, batch);
            });
        }
        let common = &self.buffers.common;
        submission.copy(common.summaries.raw(), 0..summary_bytes, room.start);
        let stride = 4 * self.buffers.sizes.result as u64;
        for b in 0..count as u64 {
            let range = b * stride..b * stride + gradient_bytes;
            let at = room.start + summary_bytes + b * gradient_bytes;
            submission.copy(common.result.raw(), range, at);
        }
        Ok(())
    }

    /// Unpacks what [`Recorder::record_end_step`] brought back in `bytes`.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::Invalid`] where `bytes` or `out` are others.
    pub fn finish_end_step(&mut self, bytes: &[u8], out: &mut [StepEnd]) -> Result<()> {
        self.checks.count("out", out.len())?;
        let bytes = part(bytes, &self.ends)?;
        if bytes.is_empty() {
            return Ok(());
        }
        let (summaries, gradients) = bytes.split_at(self.ended.len() * size_of::<Summary>());
        if !gradients.chunks_exact(4).all(|b| is_sound(float(b))) {
            return Err(Error::NotFinite {
                quantity: "gradient of the tissue by frames",
            });
        }
        let summaries = summaries.chunks_exact(size_of::<Summary>());
        let gradients = gradients.chunks_exact(self.buffers.sizes.frame_gradient_bytes());
        for ((&instance, summary), gradient) in self.ended.iter().zip(summaries).zip(gradients) {
            let summary: Summary = bytemuck::pod_read_unaligned(summary);
            let end = &mut out[instance as usize];
            end.energies = energies(&summary)?;
            end.contact_force = Vec3::from_array(summary.energy.force).as_dvec3();
            end.contacts = summary.contacts as usize;
            end.contacts_left_out = summary.energy.left_out as usize;
            end.frame_gradient.clear();
            let numbers = gradient.chunks_exact(4).map(|b| f64::from(float(b)));
            end.frame_gradient.extend(numbers);
        }
        Ok(())
    }
}
