//! Backtracking line search of a batch of instances.

use super::newton::Newton;
use super::report::{Stop, Timings};
use crate::Result;
use crate::math::Stopwatch;
use crate::model::State;
use crate::potential::{Potential, Trial};

/// Step lengths tried in one call; the next call goes on where they end.
const TRIALS: usize = 4;

/// Calls before the direction is given up: the last α is 2⁻¹¹.
const CALLS: i32 = 3;

/// Share of the predicted decrease α gᵀδ that has to be reached (Nocedal and Wright, §3.1).
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// Room for the trials.
#[derive(Default)]
pub(super) struct LineSearch {
    states: Vec<State>,
    differences: Vec<f64>,
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
        for call in 0..CALLS {
            if self.search.pending.is_empty() {
                return Ok(());
            }
            let alphas: [f64; TRIALS] =
                std::array::from_fn(|k| 0.5f64.powi(call * TRIALS as i32 + k as i32));
            self.try_lengths(potential, &alphas, timings).await?;
            self.accept(&alphas);
        }
        for &i in &self.search.pending {
            self.lanes[i].report.stop = Stop::LineSearchStalled;
            self.running[i] = false;
        }
        Ok(())
    }

    /// Fills in E(q + αδ) − E(q) for every pending instance and α.
    async fn try_lengths<P: Potential>(
        &mut self,
        potential: &mut P,
        alphas: &[f64; TRIALS],
        timings: &mut Timings,
    ) -> Result<()> {
        let watch = Stopwatch::start();
        let search = &mut self.search;
        let count = search.pending.len() * TRIALS;
        while search.states.len() < count {
            search.states.push(self.states[0].clone());
        }
        search.differences.resize(count, 0.0);
        let mut trials = Vec::with_capacity(count);
        for (&i, states) in search.pending.iter().zip(search.states.chunks_mut(TRIALS)) {
            for (state, alpha) in states.iter_mut().zip(alphas) {
                state.clone_from(&self.states[i]);
                state.move_by(&self.lanes[i].step, *alpha);
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
            let skeleton = &self.lanes[trial.instance].skeleton;
            *difference += skeleton
                .difference(&trial.base.frames, &trial.state.frames)
                .total();
        }
        timings.evaluation += watch.ms();
        Ok(())
    }

    /// Moves the pending instances for which an α is good enough, and keeps the others pending.
    fn accept(&mut self, alphas: &[f64; TRIALS]) {
        let search = &mut self.search;
        let mut k = 0;
        search.pending.retain(|&i| {
            let found = (0..TRIALS).find(|t| {
                let demanded = SUFFICIENT_DECREASE * alphas[*t] * self.lanes[i].report.decrement;
                // False for NaN: a trial that overflows is a bad one.
                search.differences[k * TRIALS + t] <= -demanded
            });
            if let Some(t) = found {
                self.states[i].clone_from(&search.states[k * TRIALS + t]);
            }
            k += 1;
            found.is_none()
        });
    }
}
