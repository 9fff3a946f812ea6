//! Newton's method on the incremental potential, for a batch of instances.
//!
//! Each iteration solves H δ = −g and moves the iterate, q ← q + αδ.

use super::iterates::Iterates;
use super::iteration::{Iteration, Observer};
use super::line_search::LineSearch;
use super::linear_solver::LinearSolver;
use super::minimisation::Minimisation;
use super::report::{Stop, Timings};
use super::settings::SolverMode;
use crate::Result;
use crate::math::Stopwatch;
use crate::model::State;
use crate::potential::Potential;

/// What f32 resolves of E, J: a smaller rise is noise.
const ENERGY_RESOLUTION: f64 = 1e-8;

/// Trust radius of [`SolverMode::OneIteration`], m: a Newton step no longer than this is taken whole, without a look at
/// E where it ends. A longer one, though it starts at the prediction, means that the quadratic model lacks something (a
/// contact that is being made), and is searched along.
const TRUST_RADIUS: f64 = 1e-3;

/// Minimises E of all active instances in lockstep. Everything is kept from step to step, so that a
/// step allocates nothing.
#[derive(Default)]
pub(super) struct Newton {
    /// One for each instance.
    pub minimisations: Vec<Minimisation>,
    /// Which instances take part.
    pub active: Vec<bool>,
    /// The predictions before, the results after.
    pub iterates: Iterates,
    /// Where the minimisations start whose prediction raises the energy, see [`super::prediction::fall_back`].
    pub fallbacks: Iterates,
    /// Which minimisations have not ended yet.
    running: Vec<bool>,
    /// Which predictions raise the energy.
    rising: Vec<bool>,
    line_search: LineSearch,
}

impl Newton {
    /// Room for instances like `rest`, none of them active.
    pub fn new(minimisations: Vec<Minimisation>, rest: &State) -> Self {
        let count = minimisations.len();
        Self {
            minimisations,
            active: vec![false; count],
            iterates: Iterates::new(count, rest),
            fallbacks: Iterates::new(count, rest),
            running: vec![false; count],
            rising: vec![false; count],
            line_search: LineSearch::default(),
        }
    }

    /// Minimises from the predictions in [`Newton::iterates`], or the fall-backs, and leaves the results there.
    pub async fn minimise<P: Potential>(
        &mut self,
        potential: &mut P,
        solver: &mut dyn LinearSolver,
        mode: SolverMode,
        timings: &mut Timings,
        observer: &mut Observer<'_>,
    ) -> Result<()> {
        let (short, when_short, max_iterations, at_limit) = match mode {
            SolverMode::OneIteration => (TRUST_RADIUS, Stop::OneIteration, 1, Stop::OneIteration),
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
        self.start(potential, timings).await?;
        for iteration in 1..=max_iterations {
            if iteration > 1 {
                self.evaluate(potential, timings).await?;
            }
            self.solve(solver, timings)?;
            self.show(observer);
            self.take_short_steps(short, when_short);
            self.search_line(potential, timings).await?;
            if !self.running.contains(&true) {
                return Ok(());
            }
        }
        self.stop_running(at_limit);
        Ok(())
    }

    /// Evaluates the predictions, then the fall-backs of those that raise the energy, and keeps the lower.
    async fn start<P: Potential>(
        &mut self,
        potential: &mut P,
        timings: &mut Timings,
    ) -> Result<()> {
        self.evaluate(potential, timings).await?;
        for (i, rising) in self.rising.iter_mut().enumerate() {
            let falling = self.iterates.energy(i) <= ENERGY_RESOLUTION;
            // A prediction that overflows is a rise as well.
            *rising = self.running[i] && !falling;
        }
        if !self.rising.contains(&true) {
            return Ok(());
        }
        self.fallbacks
            .evaluate(potential, &self.minimisations, &self.rising, timings)
            .await?;
        for i in (0..self.rising.len()).filter(|&i| self.rising[i]) {
            // Pins can carry the bones so far from qⁿ that the prediction is the lower all the same.
            let lower = self.iterates.energy(i) <= self.fallbacks.energy(i);
            if !lower {
                self.iterates.swap(i, &mut self.fallbacks);
                self.minimisations[i].report.started_at_current = true;
            }
        }
        Ok(())
    }

    /// Evaluates E, gradient and Hessian at the iterates of running instances.
    async fn evaluate<P: Potential>(
        &mut self,
        potential: &mut P,
        timings: &mut Timings,
    ) -> Result<()> {
        self.iterates
            .evaluate(potential, &self.minimisations, &self.running, timings)
            .await
    }

    /// Solves for the Newton step of every running instance.
    fn solve(&mut self, solver: &mut dyn LinearSolver, timings: &mut Timings) -> Result<()> {
        let watch = Stopwatch::start();
        for i in (0..self.running.len()).filter(|&i| self.running[i]) {
            self.minimisations[i].solve(
                solver,
                &mut self.iterates.evaluations[i],
                self.iterates.skeleton_energies[i],
            )?;
        }
        timings.solve += watch.ms();
        Ok(())
    }

    /// Shows the iteration of every running instance.
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

    /// Moves every running instance whose step is no longer than `length` by its whole step, and ends its
    /// minimisation.
    fn take_short_steps(&mut self, length: f64, stop: Stop) {
        for (i, minimisation) in self.minimisations.iter_mut().enumerate() {
            if self.running[i] && minimisation.report.step_length <= length {
                self.iterates.states[i].move_by(&minimisation.step, 1.0);
                minimisation.report.stop = stop;
                self.running[i] = false;
            }
        }
    }

    /// Moves what still runs as far along its step as lowers the energy.
    async fn search_line<P: Potential>(
        &mut self,
        potential: &mut P,
        timings: &mut Timings,
    ) -> Result<()> {
        let (minimisations, states) = (&mut self.minimisations, &mut self.iterates.states);
        self.line_search
            .search(potential, minimisations, states, &mut self.running, timings)
            .await
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
