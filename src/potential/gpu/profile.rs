//! What each stage of an evaluation costs.

use super::potential::GpuPotential;
use super::shared::Summary;
use super::stages::{Dispatch, Stages};
use crate::Result;
use crate::gpu::Submission;
use crate::math::Stopwatch;

impl GpuPotential {
    /// Least wall-clock seconds of each stage over `repeats` runs on the states of the last
    /// [`evaluate`](crate::potential::Potential::evaluate), every stage submitted and waited for by
    /// itself; the first entry is such a submission with nothing in it.
    ///
    /// # Errors
    /// [`crate::GpuError::DeviceLost`].
    pub async fn stage_times(&mut self, repeats: usize) -> Result<Vec<(&'static str, f64)>> {
        let empty: (&str, Dispatch) = ("submission", Box::new(|_, _, _| {}));
        self.submission.flush();
        let bytes = size_of::<Summary>() as u64;
        let patience = self.recorder.patience();
        let mut submission = Submission::new(&self.device, &self.queue, "stage", bytes, patience)?;
        let (recorder, mut times) = (&self.recorder, Vec::new());
        for (name, dispatch) in std::iter::once(empty).chain(Stages::timed()) {
            let mut least = f64::INFINITY;
            for _ in 0..repeats.max(1) {
                let clock = Stopwatch::start();
                recorder.dispatch(&mut submission, |stages, pass| {
                    for batch in recorder.chunks(recorder.batch.len()) {
                        dispatch(stages, pass, batch);
                    }
                });
                let at = submission.reserve(bytes)?.start;
                let summaries = recorder.buffers.common.summaries.raw();
                submission.copy(summaries, 0..bytes, at);
                drop(submission.read().await?);
                least = least.min(clock.ms() / 1e3);
            }
            times.push((name, least));
        }
        Ok(times)
    }
}
