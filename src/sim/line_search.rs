//! Backtracking line search of a batch of instances.

use super::minimisation::Minimisation;
use super::report::{Stop, Timings};
use crate::Result;
use crate::math::{Stopwatch, recycled};
use crate::model::State;
use crate::potential::{Potential, Trial};

/// Step lengths α tried in one call, call by call: the whole step mostly serves, and what follows shares its calls.
const CALLS: [&[f64]; 4] = [
    &[1.0],
    &[0.5, 0.25, 0.125, 0.0625],
    &[3.125e-2, 1.5625e-2, 7.8125e-3, 3.90625e-3],
    &[1.953125e-3, 9.765625e-4, 4.8828125e-4],
];

/// Armijo's constant, c in E(q + αδ) − E(q) ≤ c α gᵀδ (Nocedal and Wright, §3.1).
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// Memory of the trials, kept from search to search.
#[derive(Default)]
pub(super) struct LineSearch {
    states: Vec<State>,
    differences: Vec<f64>,
    trials: Vec<Trial<'static>>,
    /// Instances for which no α has served so far.
    pending: Vec<usize>,
}

impl LineSearch {
    /// Moves every running instance along its step by the first α of 1, ½, ¼, … that lowers the energy
    /// sufficiently. Where none does, the instance stays and stops.
    pub async fn search<P: Potential>(
        &mut self,
        potential: &mut P,
        minimisations: &mut [Minimisation],
        states: &mut [State],
        running: &mut [bool],
        timings: &mut Timings,
    ) -> Result<()> {
        self.pending.clear();
        self.pending
            .extend((0..running.len()).filter(|&i| running[i]));
        for alphas in CALLS {
            if self.pending.is_empty() {
                return Ok(());
            }
            let watch = Stopwatch::start();
            self.try_lengths(potential, minimisations, states, alphas)
                .await?;
            timings.evaluation += watch.ms();
            self.accept(minimisations, states, alphas);
        }
        for &i in &self.pending {
            minimisations[i].report.stop = Stop::LineSearchStalled;
            running[i] = false;
        }
        Ok(())
    }

    /// Fills in E(q + αδ) − E(q) for every pending instance and α.
    async fn try_lengths<P: Potential>(
        &mut self,
        potential: &mut P,
        minimisations: &[Minimisation],
        states: &[State],
        alphas: &[f64],
    ) -> Result<()> {
        let count = self.pending.len() * alphas.len();
        while self.states.len() < count {
            self.states.push(states[0].clone());
        }
        self.differences.resize(count, 0.0);
        let mut trials: Vec<Trial<'_>> = recycled(std::mem::take(&mut self.trials));
        let moved = self.states.chunks_mut(alphas.len());
        for (&i, moved) in self.pending.iter().zip(moved) {
            for (state, alpha) in moved.iter_mut().zip(alphas) {
                state.clone_from(&states[i]);
                state.move_by(&minimisations[i].step, *alpha);
                trials.push(Trial {
                    instance: i,
                    base: &states[i],
                    state,
                });
            }
        }
        potential
            .energy_differences(&trials, &mut self.differences)
            .await?;
        for (trial, difference) in trials.iter().zip(&mut self.differences) {
            let skeleton = &minimisations[trial.instance].skeleton;
            *difference += skeleton
                .difference(&trial.base.frames, &trial.state.frames)
                .total();
        }
        self.trials = recycled(trials);
        Ok(())
    }

    /// Moves the pending instances for which an α is good enough, and keeps the others pending.
    fn accept(&mut self, minimisations: &[Minimisation], states: &mut [State], alphas: &[f64]) {
        let mut k = 0;
        self.pending.retain(|&i| {
            let found = (0..alphas.len()).find(|t| {
                let demanded = SUFFICIENT_DECREASE * alphas[*t] * minimisations[i].report.decrement;
                // False for NaN: a trial that overflows is a bad one.
                self.differences[k * alphas.len() + t] <= -demanded
            });
            if let Some(t) = found {
                states[i].clone_from(&self.states[k * alphas.len() + t]);
            }
            k += 1;
            found.is_none()
        });
    }
}
