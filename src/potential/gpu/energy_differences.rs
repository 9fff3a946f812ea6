//! Energy differences on the GPU: the trials of a line search.

use super::Batch;
use super::evaluate::energies;
use super::potential::{GpuPotential, Start};
use super::shared::{BatchState, Summary};
use crate::potential::Trial;
use crate::{Error, Result};

impl GpuPotential {
    /// E(state) − E(base) of each trial; as many at once as the options have room for.
    pub(super) async fn compare(&mut self, trials: &[Trial<'_>], out: &mut [f64]) -> Result<()> {
        if trials.len() != out.len() {
            return Err(Error::invalid("out", "must be as long as the trials"));
        }
        let instances = self.starts.len();
        let most = self.options.trials.max(1);
        for (trials, out) in trials.chunks(most).zip(out.chunks_mut(most)) {
            self.clear_uploads();
            // First the trials, then the bases they are measured from, each base once.
            let mut bases: Vec<&Trial<'_>> = Vec::new();
            for trial in trials {
                self.check_state(trial.base)?;
                self.check_state(trial.state)?;
                let Start { origin, header, .. } = self.start(trial.instance)?.clone();
                let base = bases
                    .iter()
                    .position(|b| b.instance == trial.instance && b.base == trial.base)
                    .unwrap_or_else(|| {
                        bases.push(trial);
                        bases.len() - 1
                    });
                let header = BatchState {
                    slot: (instances + self.batch.len()) as u32,
                    base: (instances + trials.len() + base) as u32,
                    ..header
                };
                self.push(header, trial.base, trial.state, origin);
            }
            for trial in bases {
                let Start {
                    origin,
                    current,
                    header,
                    ..
                } = self.start(trial.instance)?.clone();
                let header = BatchState {
                    slot: (instances + self.batch.len()) as u32,
                    base: header.instance,
                    ..header
                };
                self.push(header, &current, trial.base, origin);
            }
            self.upload(instances);
            let batch = |states: usize| Batch {
                chunk: 0,
                states: states as u32,
            };
            let bytes = (trials.len() * size_of::<Summary>()) as u64;
            self.submit(
                |stages, pass| {
                    stages.displacement.dispatch(pass, batch(self.batch.len()));
                    stages.contact.dispatch(pass, batch(self.batch.len()));
                    if self.has_friction {
                        stages.friction.dispatch(pass, batch(self.batch.len()));
                    }
                    stages.energy.dispatch(pass, batch(trials.len()));
                },
                |encoder| {
                    let summaries = self.buffers.summaries.raw();
                    self.readback.record(encoder, summaries, 0..bytes, 0);
                },
            );
            let unpack = |bytes: &[u8]| {
                let summaries = bytes.chunks_exact(size_of::<Summary>());
                for (out, bytes) in out.iter_mut().zip(summaries) {
                    let energies = energies(&bytemuck::pod_read_unaligned(bytes));
                    *out = energies.map_or(f64::NAN, |e| e.total());
                }
            };
            self.readback.read(&self.device, bytes, unpack).await?;
        }
        Ok(())
    }
}
