//! Backtracking line search of a batch of instances.

use super::newton::Newton;
use super::report::{Stop, Timings};
use crate::Result;
use crate::math::{Stopwatch, recycled};
use crate::model::State;
use crate::potential::{Potential, Trial};

/// Step lengths tried in one call, call by call: the whole step mostly serves, and what follows shares its calls.
const CALLS: [&[f64]; 4] = [
    &[1.0],
    &[0.5, 0.25, 0.125, 0.0625],
    &[3.125e-2, 1.5625e-2, 7.8125e-3, 3.90625e-3],
    &[1.953125e-3, 9.765625e-4, 4.8828125e-4],
];

/// Share of the predicted decrease α gᵀδ that has to be reached (Nocedal and Wright, §3.1).
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// Room for the trials.
#[derive(Default)]
pub(super) struct LineSearch {
    states: Vec<State>,
    differences: Vec<f64>,
    trials: Vec<Trial<'static>>,
    pending: Vec<usize>,
}

impl Newton {
    /// Moves every running instance along its step by the first α of 1, ½, ¼, … that lowers the energy
    /// sufficiently. Where none does, the instance stays and stops.
    pub(super) async fn line_search<P: Potential>(
        &mut self,
        potential: &mut P,
        timings: &mut Timings,
    ) -> Result<()> {
        self.search.pending.clear();
        let running = self.running.iter().enumerate();
        self.search
            .pending
            .extend(running.filter(|(_, r)| **r).map(|(i, _)| i));
        for alphas in CALLS {
            if self.search.pending.is_empty() {
                return Ok(());
            }
            self.try_lengths(potential, alphas, timings).await?;
            self.accept(alphas);
        }
        for &i in &self.search.pending {
            self.minimisations[i].report.stop = Stop::LineSearchStalled;
            self.running[i] = false;
        }
        Ok(())
    }

    /// Fills in E(q + αδ) − E(q) for every pending instance and α.
    async fn try_lengths<P: Potential>(
        &mut self,
        potential: &mut P,
        alphas: &[f64],
        timings: &mut Timings,
    ) -> Result<()> {
        let watch = Stopwatch::start();
        let search = &mut self.search;
        let count = search.pending.len() * alphas.len();
        while search.states.len() < count {
            search.states.push(self.states[0].clone());
        }
        search.differences.resize(count, 0.0);
        let mut trials: Vec<Trial<'_>> = recycled(std::mem::take(&mut search.trials));
        for (&i, states) in search
            .pending
            .iter()
            .zip(search.states.chunks_mut(alphas.len()))
        {
            for (state, alpha) in states.iter_mut().zip(alphas) {
                state.clone_from(&self.states[i]);
                state.move_by(&self.minimisations[i].step, *alpha);
                trials.push(Trial {
                    instance: i,
                    base: &self.states[i],
                    state,
                });
            }
        }
        potential
            .energy_differences(&trials, &mut search.differences)
            .await?;
        for (trial, difference) in trials.iter().zip(&mut search.differences) {
            let skeleton = &self.minimisations[trial.instance].skeleton;
            *difference += skeleton
                .difference(&trial.base.frames, &trial.state.frames)
                .total();
        }
        search.trials = recycled(trials);
        timings.evaluation += watch.ms();
        Ok(())
    }

    /// Moves the pending instances for which an α is good enough, and keeps the others pending.
    fn accept(&mut self, alphas: &[f64]) {
        let search = &mut self.search;
        let mut k = 0;
        search.pending.retain(|&i| {
            let found = (0..alphas.len()).find(|t| {
                let demanded =
                    SUFFICIENT_DECREASE * alphas[*t] * self.minimisations[i].report.decrement;
                // False for NaN: a trial that overflows is a bad one.
                search.differences[k * alphas.len() + t] <= -demanded
            });
            if let Some(t) = found {
                self.states[i].clone_from(&search.states[k * alphas.len() + t]);
            }
            k += 1;
            found.is_none()
        });
    }
}
