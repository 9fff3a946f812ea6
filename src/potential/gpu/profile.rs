//! What each stage of an evaluation costs.

use super::potential::GpuPotential;
use super::shared::Summary;
use super::stages::{Dispatch, Stages};
use crate::Result;
use std::time::Instant;

impl GpuPotential {
    /// Least wall-clock seconds of each stage over `repeats` runs on the states of the last
    /// [`evaluate`](crate::potential::Potential::evaluate), every stage submitted and waited for by
    /// itself; the first entry is such a submission with nothing in it.
    ///
    /// # Errors
    /// [`crate::GpuError::DeviceLost`].
    pub async fn stage_times(&mut self, repeats: usize) -> Result<Vec<(&'static str, f64)>> {
        let empty: (&str, Dispatch) = ("submission", Box::new(|_, _, _| {}));
        let mut times = Vec::new();
        for (name, dispatch) in std::iter::once(empty).chain(Stages::timed()) {
            let mut least = f64::INFINITY;
            for _ in 0..repeats.max(1) {
                let clock = Instant::now();
                let bytes = size_of::<Summary>() as u64;
                self.submit(
                    |stages, pass| {
                        for batch in self.chunks(self.batch.len()) {
                            dispatch(stages, pass, batch);
                        }
                    },
                    |encoder| {
                        let summaries = self.buffers.common.summaries.raw();
                        self.readback.record(encoder, summaries, 0..bytes, 0);
                    },
                );
                self.readback.read(&self.device, bytes, |_| ()).await?;
                least = least.min(clock.elapsed().as_secs_f64());
            }
            times.push((name, least));
        }
        Ok(times)
    }
}
