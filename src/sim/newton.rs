//! Newton's method on the incremental potential, for a batch of instances.
//!
//! Each iteration solves H δ = −g and moves the iterate, q ← q + αδ.

use super::coupled::Coupled;
use super::groups::Groups;
use super::iterates::Iterates;
use super::iteration::{Iteration, Observer};
use super::line_search::{ENERGY_RESOLUTION, LineSearch};
use super::members::Members;
use super::minimisation::Minimisation;
use super::report::{Stop, Timings};
use super::settings::SolverMode;
use super::solvers::Systems;
use crate::Result;
use crate::math::{Stopwatch, par_members, par_split};
use crate::model::State;

/// Trust radius of [`SolverMode::OneIteration`], m: a Newton step no longer than this is taken whole, without a look at
/// E where it ends. A longer one, though it starts at the prediction, means that the quadratic model lacks something (a
/// contact that is being made), and is searched along.
const TRUST_RADIUS: f64 = 1e-3;

/// Minimises E of all active members in lockstep, each group as one. Everything is kept from step to step, so that a
/// step allocates nothing.
#[derive(Default)]
pub(super) struct Newton {
    /// One for each member.
    pub minimisations: Vec<Minimisation>,
    /// Which members take part; those of a group all do or none.
    pub active: Vec<bool>,
    /// The predictions before, the results after.
    pub iterates: Iterates,
    /// Where the minimisations start whose prediction raises the energy, see [`super::prediction::carry_on`].
    pub others: Iterates,
    /// And where those start for which that raises it too, see [`super::prediction::fall_back`].
    pub fallbacks: Vec<State>,
    /// Which members move in one linear system.
    pub groups: Groups,
    systems: Systems,
    coupled: Coupled,
    /// Which minimisations have not ended yet.
    running: Vec<bool>,
    /// Which predictions raise the energy.
    rising: Vec<bool>,
    line_search: LineSearch,
}

impl Newton {
    /// Room for these members, none of them active and each by itself.
    pub fn new(minimisations: Vec<Minimisation>, systems: Systems) -> Self {
        let count = minimisations.len();
        let states = || minimisations.iter().map(|m| m.current.clone()).collect();
        Self {
            active: vec![false; count],
            iterates: Iterates::new(states()),
            others: Iterates::new(states()),
            fallbacks: states(),
            groups: Groups::singles(count),
            systems,
            coupled: Coupled::default(),
            running: vec![false; count],
            rising: vec![false; count],
            line_search: LineSearch::default(),
            minimisations,
        }
    }

    /// Minimises from the predictions in [`Newton::iterates`], or the fall-backs, and leaves the results there.
    pub async fn minimise<M: Members>(
        &mut self,
        members: &mut M,
        mode: SolverMode,
        timings: &mut Timings,
        observer: &mut Observer<'_>,
    ) -> Result<()> {
        let budgeted = matches!(mode, SolverMode::Budgeted { .. });
        let (short, when_short, max_iterations, at_limit) = match mode {
            SolverMode::OneIteration => (TRUST_RADIUS, Stop::OneIteration, 1, Stop::OneIteration),
            SolverMode::Budgeted { max_iterations } => (
                TRUST_RADIUS,
                Stop::AsModelled,
                max_iterations,
                Stop::IterationLimit,
            ),
            SolverMode::Converged {
                tolerance,
                max_iterations,
            } => (
                tolerance,
                Stop::Converged,
                max_iterations,
                Stop::IterationLimit,
            ),
        };
        self.running.clone_from(&self.active);
        self.start(members, timings).await?;
        for iteration in 1..=max_iterations {
            if iteration > 1 {
                self.evaluate(members, timings).await?;
            }
            self.solve(timings)?;
            self.show(observer);
            self.take_short_steps(short, when_short, budgeted);
            self.search_line(members, timings, budgeted).await?;
            if !self.running.contains(&true) {
                return Ok(());
            }
        }
        self.stop_running(at_limit);
        Ok(())
    }

    /// Evaluates the predictions; of those that raise the energy the bones' alone; of those that do so too the fall-backs. Keeps
    /// the lowest.
    async fn start<M: Members>(&mut self, members: &mut M, timings: &mut Timings) -> Result<()> {
        self.evaluate(members, timings).await?;
        self.others.make_room_like(&self.iterates);
        self.find_rising();
        for fallback in [false, true] {
            if !self.rising.contains(&true) {
                return Ok(());
            }
            if fallback {
                let states = self.others.states.iter_mut().zip(&mut self.fallbacks);
                let rising = states.zip(&self.rising).filter(|(_, rising)| **rising);
                rising.for_each(|((state, fallback), _)| std::mem::swap(state, fallback));
            }
            self.start_elsewhere(members, timings).await?;
            self.find_rising();
        }
        Ok(())
    }

    /// Which starts raise the energy.
    fn find_rising(&mut self) {
        for group in 0..self.groups.len() {
            let group = self.groups.members(group);
            let falling = self.iterates.energy(group) <= ENERGY_RESOLUTION;
            for &i in group {
                // A start that overflows is a rise as well.
                self.rising[i] = self.running[i] && !falling;
            }
        }
    }

    /// Takes the other starts of those that rise, where they are lower.
    async fn start_elsewhere<M: Members>(
        &mut self,
        members: &mut M,
        timings: &mut Timings,
    ) -> Result<()> {
        let (minimisations, systems) = (&self.minimisations, &self.systems);
        (self.others)
            .evaluate(members, minimisations, systems, &self.rising, timings)
            .await?;
        for group in 0..self.groups.len() {
            let group = self.groups.members(group);
            // Pins can carry the bones so far from qⁿ that the prediction is the lower all the same.
            let lower = self.iterates.energy(group) <= self.others.energy(group);
            for &i in group.iter().filter(|&&i| self.rising[i] && !lower) {
                self.iterates.swap(i, &mut self.others);
                self.minimisations[i].report.started_at_current = true;
            }
        }
        Ok(())
    }

    /// Evaluates E, gradient and Hessian at the iterates of running members.
    async fn evaluate<M: Members>(&mut self, members: &mut M, timings: &mut Timings) -> Result<()> {
        self.iterates
            .evaluate(
                members,
                &self.minimisations,
                &self.systems,
                &self.running,
                timings,
            )
            .await
    }

    /// Solves for the Newton step of every running member.
    fn solve(&mut self, timings: &mut Timings) -> Result<()> {
        let watch = Stopwatch::start();
        self.solve_singles();
        self.coupled.solve(
            &self.groups,
            &self.systems,
            &self.running,
            &mut self.minimisations,
            &self.iterates,
        );
        timings.solve += watch.ms();
        for (minimisation, running) in self.minimisations.iter_mut().zip(&self.running) {
            if *running {
                std::mem::replace(&mut minimisation.solved, Ok(()))?;
            }
        }
        Ok(())
    }

    /// Solves for what is alone in its group, one member a task.
    fn solve_singles(&mut self) {
        let Iterates {
            evaluations,
            skeleton_energies,
            ..
        } = &mut self.iterates;
        let skeleton_energies = &*skeleton_energies;
        let (running, groups, systems) = (&self.running, &self.groups, &self.systems);
        let solve = |i: usize, (minimisation, evaluation)| {
            let minimisation: &mut Minimisation = minimisation;
            if running[i] && groups.is_alone(i) {
                let energies = skeleton_energies[i];
                minimisation.solved =
                    systems.lend(i, |solver| minimisation.solve(solver, evaluation, energies));
            }
        };
        let parts = (&mut self.minimisations[..], &mut evaluations[..]);
        if systems.in_turn() {
            par_split(running.len(), running.len(), parts, solve);
        } else {
            par_members(running.len(), parts, solve);
        }
    }

    /// Shows the iteration of every running member.
    fn show(&self, observer: &mut Observer<'_>) {
        for (i, minimisation) in self.minimisations.iter().enumerate() {
            if self.running[i] {
                observer(&Iteration {
                    instance: i,
                    state: &self.iterates.states[i],
                    gradient: &self.iterates.evaluations[i].gradient,
                    fixed: &minimisation.fixed,
                    step: &minimisation.step,
                    report: &minimisation.report,
                });
            }
        }
    }

    /// Moves every running member whose step is no longer than `length` (a group's is the longest of its members) by
    /// its whole step, and ends its minimisation; where it must be `without_contact`, none of what touches something.
    fn take_short_steps(&mut self, length: f64, stop: Stop, without_contact: bool) {
        for i in 0..self.minimisations.len() {
            let short = self.running[i] && self.minimisations[i].report.step_length <= length;
            let group = self.groups.members(self.groups.of(i));
            let touches = || group.iter().any(|&j| self.minimisations[j].may_touch);
            if short && !(without_contact && touches()) {
                let minimisation = &mut self.minimisations[i];
                self.iterates.states[i].move_by(&minimisation.step, 1.0);
                minimisation.report.stop = stop;
                self.running[i] = false;
            }
        }
    }

    /// Moves what still runs as far along its step as lowers the energy.
    async fn search_line<M: Members>(
        &mut self,
        members: &mut M,
        timings: &mut Timings,
        budgeted: bool,
    ) -> Result<()> {
        let (minimisations, states) = (&mut self.minimisations, &mut self.iterates.states);
        let (groups, running) = (&self.groups, &mut self.running);
        self.line_search
            .search(members, groups, minimisations, states, running, timings)
            .await?;
        if !budgeted {
            return Ok(());
        }
        for group in 0..groups.len() {
            let group = groups.members(group);
            if running[group[0]] && self.line_search.as_modelled(group, minimisations) {
                for &i in group {
                    minimisations[i].report.stop = Stop::AsModelled;
                    running[i] = false;
                }
            }
        }
        Ok(())
    }

    /// Ends the minimisation of what still runs.
    fn stop_running(&mut self, stop: Stop) {
        for (running, minimisation) in self.running.iter_mut().zip(&mut self.minimisations) {
            if std::mem::take(running) {
                minimisation.report.stop = stop;
            }
        }
    }
}
