//! Backtracking line search of a batch of instances.

use super::groups::Groups;
use super::members::Members;
use super::minimisation::Minimisation;
use super::report::{Stop, Timings};
use crate::Result;
use crate::math::{Stopwatch, recycled};
use crate::model::State;
use crate::potential::{Difference, Trial};

/// Step lengths α tried in one call, call by call: the whole step mostly serves, and what follows shares its calls.
const CALLS: [&[f64]; 4] = [
    &[1.0],
    &[0.5, 0.25, 0.125, 0.0625],
    &[3.125e-2, 1.5625e-2, 7.8125e-3, 3.90625e-3],
    &[1.953125e-3, 9.765625e-4, 4.8828125e-4],
];

/// The most of one call.
const MOST_LENGTHS: usize = 4;

/// Armijo's constant, c in E(q + αδ) − E(q) ≤ c α gᵀδ (Nocedal and Wright, §3.1).
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// What f32 resolves of E, J: a smaller rise is noise.
pub(super) const ENERGY_RESOLUTION: f64 = 1e-8;

/// Part of the modelled fall of E by which it may miss.
const MODEL_ERROR: f64 = 0.1;

/// Part of the force of all contacts that may be unforeseen.
const UNFORESEEN: f64 = 0.05;

/// Memory of the trials, kept from search to search.
#[derive(Default)]
pub(super) struct LineSearch {
    states: Vec<State>,
    differences: Vec<Difference>,
    trials: Vec<Trial<'static>>,
    /// Groups for which no α has served so far.
    pending: Vec<usize>,
    /// Of the groups of members that were searched: what came of the whole step where it served.
    whole: Vec<Option<Difference>>,
}

impl LineSearch {
    /// Moves every running group along its step by the first α of 1, ½, ¼, … that lowers its energy sufficiently.
    /// Where none does, the group stays and stops.
    pub async fn search<M: Members>(
        &mut self,
        members: &mut M,
        groups: &Groups,
        minimisations: &mut [Minimisation],
        states: &mut [State],
        running: &mut [bool],
        timings: &mut Timings,
    ) -> Result<()> {
        self.pending.clear();
        self.whole.clear();
        self.whole.resize(minimisations.len(), None);
        let runs = |g: &usize| running[groups.members(*g)[0]];
        self.pending.extend((0..groups.len()).filter(runs));
        for alphas in CALLS {
            if self.pending.is_empty() {
                return Ok(());
            }
            let watch = Stopwatch::start();
            self.try_lengths(members, groups, minimisations, states, alphas)
                .await?;
            timings.evaluation += watch.ms();
            self.accept(groups, minimisations, states, alphas);
        }
        for &i in self.pending.iter().flat_map(|&g| groups.members(g)) {
            minimisations[i].report.stop = Stop::LineSearchStalled;
            running[i] = false;
        }
        Ok(())
    }

    /// Whether a group took its whole step, E fell by what the quadratic model says, half the decrement, and no contact did
    /// what it does not see.
    pub fn as_modelled(&self, group: &[usize], minimisations: &[Minimisation]) -> bool {
        let modelled = 0.5 * minimisations[group[0]].report.decrement;
        self.whole[group[0]].is_some_and(|difference| {
            let missed = (difference.energy + modelled).abs();
            missed <= MODEL_ERROR * modelled + ENERGY_RESOLUTION
                && difference.unforeseen_force <= UNFORESEEN * difference.pressing_force
        })
    }

    /// Fills in E(q + αδ) − E(q) for every member of a pending group and every α.
    async fn try_lengths<M: Members>(
        &mut self,
        members: &mut M,
        groups: &Groups,
        minimisations: &[Minimisation],
        states: &[State],
        alphas: &[f64],
    ) -> Result<()> {
        let tried = || {
            self.pending
                .iter()
                .flat_map(|&g| groups.members(g))
                .copied()
        };
        let count = tried().count() * alphas.len();
        self.differences.resize(count, Difference::default());
        // At once for the calls that try the most, so that later ones take no memory.
        let room = tried().count() * MOST_LENGTHS;
        if self.states.len() < room
            && let Some(like) = tried().next()
        {
            self.states.resize(room, states[like].clone());
        }
        let mut trials: Vec<Trial<'_>> = recycled(std::mem::take(&mut self.trials));
        let moved = self.states.chunks_mut(alphas.len());
        for (i, moved) in tried().zip(moved) {
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
        members
            .energy_differences(&trials, &mut self.differences)
            .await?;
        for (trial, difference) in trials.iter().zip(&mut self.differences) {
            let minimisation = &minimisations[trial.instance];
            let added = minimisation.skeleton_difference(trial.base, trial.state);
            difference.energy += added.total();
        }
        self.trials = recycled(trials);
        Ok(())
    }

    /// Moves the pending groups for which an α is good enough, and keeps the others pending.
    fn accept(
        &mut self,
        groups: &Groups,
        minimisations: &[Minimisation],
        states: &mut [State],
        alphas: &[f64],
    ) {
        let mut first = 0;
        self.pending.retain(|&g| {
            let members = groups.members(g);
            let tried = first..first + members.len();
            first = tried.end;
            let lowers = |t: &usize| {
                let difference = |k: usize| self.differences[k * alphas.len() + t].energy;
                let decrement = minimisations[members[0]].report.decrement;
                let demanded = SUFFICIENT_DECREASE * alphas[*t] * decrement;
                // False for NaN: a trial that overflows is a bad one.
                tried.clone().map(difference).sum::<f64>() <= -demanded
            };
            let found = (0..alphas.len()).find(lowers);
            if let Some(t) = found {
                if alphas[t] == 1.0 {
                    let mut sum = Difference::default();
                    for k in tried.clone() {
                        let of_member = &self.differences[k * alphas.len() + t];
                        sum.energy += of_member.energy;
                        sum.unforeseen_force += of_member.unforeseen_force;
                        sum.pressing_force += of_member.pressing_force;
                    }
                    self.whole[members[0]] = Some(sum);
                }
                for (k, &i) in tried.clone().zip(members) {
                    states[i].clone_from(&self.states[k * alphas.len() + t]);
                }
            }
            found.is_none()
        });
    }
}
