//! Energy differences on the GPU: the trials of a line search.

use super::dispatch::Batch;
use super::evaluate::energies;
use super::recorder::{Recorder, Start};
use super::shared::{BatchState, Summary};
use super::stage::Stage;
use crate::Result;
use crate::gpu::Submission;
use crate::potential::{Difference, Trial};

impl Recorder {
    /// E(state) − E(base) of the first of `trials`: as many as there is room for. Returns how many, at least one where
    /// there is one; the rest goes in another submission.
    ///
    /// # Errors
    /// As [`Potential::energy_differences`](crate::potential::Potential::energy_differences), and
    /// [`crate::GpuError::Limit`] where the submission has no room to read it back; nothing is recorded then.
    pub fn record_energy_differences(
        &mut self,
        trials: &[Trial<'_>],
        submission: &mut Submission,
    ) -> Result<usize> {
        self.results = 0..0;
        let begun = |i: usize| self.starts[i].is_some();
        self.checks.trials(trials, trials.len(), begun)?;
        let trials = &trials[..self.find_bases(trials)];
        self.clear_uploads();
        self.beyond.clear();
        if trials.is_empty() {
            return Ok(0);
        }
        let instances = self.starts.len();
        // First the trials, then the bases they are measured from, each base once.
        for (i, trial) in trials.iter().enumerate() {
            let Start {
                origin,
                batch_state,
                ..
            } = self.start(trial.instance)?.clone();
            let batch_state = BatchState {
                slot: (instances + self.batch.len()) as u32,
                base: (instances + trials.len() + self.base_of[i]) as u32,
                ..batch_state
            };
            let sound = self.push_state(batch_state, trial.base, trial.state, origin);
            self.beyond.push(!sound);
        }
        for b in 0..self.bases.len() {
            let trial = &trials[self.bases[b]];
            let Start {
                origin,
                current,
                batch_state,
                ..
            } = self.start(trial.instance)?.clone();
            let batch_state = BatchState {
                slot: (instances + self.batch.len()) as u32,
                base: batch_state.instance,
                ..batch_state
            };
            if !self.push_state(batch_state, &current, trial.base, origin) {
                let measured = self.base_of.iter().zip(&mut self.beyond);
                (measured.filter(|(base, _)| **base == b)).for_each(|(_, beyond)| *beyond = true);
            }
        }
        let bytes = (trials.len() * size_of::<Summary>()) as u64;
        let room = submission.reserve(bytes)?;
        self.results = room.start as usize..room.end as usize;
        self.claim_states(submission);
        self.upload_states(instances);
        self.upload_batch(0);
        let all = Batch::whole(self.batch.len());
        self.dispatch(submission, |stages, pass| {
            stages.displacement.dispatch(pass, all);
            stages.contact.dispatch(pass, all);
            if self.has_friction {
                stages.friction.dispatch(pass, all);
            }
            // It also looks at the contacts that are counted in the scratch memory.
            for batch in self.chunks(trials.len()) {
                stages.energy.dispatch(pass, batch);
            }
        });
        let summaries = self.buffers.common.summaries.raw();
        submission.copy(summaries, 0..bytes, room.start);
        Ok(trials.len())
    }

    /// Unpacks what [`Recorder::record_energy_differences`] brought back in `bytes`, one for each trial that was recorded.
    /// Where f32 overflowed, the difference is NaN.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] where `bytes` or `out` are others.
    pub fn finish_energy_differences(
        &mut self,
        bytes: &[u8],
        out: &mut [Difference],
    ) -> Result<()> {
        let summaries = self.own(bytes)?.chunks_exact(size_of::<Summary>());
        if summaries.len() != out.len() {
            let problem = format!("{} given for {} trials", out.len(), summaries.len());
            return Err(crate::Error::invalid("out", problem));
        }
        for ((out, bytes), beyond) in out.iter_mut().zip(summaries).zip(&self.beyond) {
            let summary: Summary = bytemuck::pod_read_unaligned(bytes);
            let sound = energies(&summary).ok().filter(|_| !beyond);
            *out = Difference {
                energy: sound.map_or(f64::NAN, |e| e.total()),
                unforeseen_force: summary.energy.unforeseen.into(),
                pressing_force: summary.energy.pressing.into(),
            };
        }
        Ok(())
    }

    /// Finds the different bases of the first trials, as many as there is room for with their bases; returns how many.
    fn find_bases(&mut self, trials: &[Trial<'_>]) -> usize {
        self.bases.clear();
        self.base_of.clear();
        for (i, trial) in trials.iter().enumerate() {
            let same = |&other: &usize| {
                let other = &trials[other];
                other.instance == trial.instance
                    && (std::ptr::eq(other.base, trial.base) || other.base == trial.base)
            };
            let known = self.bases.iter().position(same);
            let states = i + 1 + self.bases.len() + usize::from(known.is_none());
            if states > self.buffers.sizes.states {
                return i;
            }
            let base = known.unwrap_or_else(|| {
                self.bases.push(i);
                self.bases.len() - 1
            });
            self.base_of.push(base);
        }
        trials.len()
    }
}
