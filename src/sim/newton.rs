//! Newton's method on the incremental potential, for a batch of instances.

use super::linear_solver::{LinearSolver, SolveReport, multiply_add};
use super::report::{InstanceReport, Stop, Timings};
use super::settings::SolverMode;
use crate::math::Stopwatch;
use crate::model::State;
use crate::potential::{Evaluation, HessianForm, Potential};
use crate::skeleton::{SkeletonEnergies, SkeletonPotential};
use crate::{Error, Result};

/// What f32 resolves of E, J: a smaller rise is noise.
pub(super) const ENERGY_RESOLUTION: f64 = 1e-8;

/// The longest step that [`SolverMode::OneIteration`] takes on trust, m: it starts at the prediction, so a longer one
/// means that the step holds something unforeseen.
const TRUST_RADIUS: f64 = 1e-3;

/// Lever at which a rotation counts as a length, m.
const ROTATION_LEVER: f64 = 0.1;

/// One instance's minimisation of E in a step: its problem, and how far it has got.
pub(super) struct Minimisation {
    /// The skeleton's terms of this step.
    pub skeleton: SkeletonPotential,
    /// qⁿ.
    pub current: State,
    /// Where the minimisation starts if the prediction raises the energy, see [`super::prediction::fall_back`].
    pub fallback: State,
    /// Which DoFs are prescribed.
    pub fixed: Vec<bool>,
    /// The Newton step δ.
    pub step: Vec<f64>,
    /// g + H δ: at fixed DoFs, what holds them.
    pub reaction: Vec<f64>,
    /// What happened.
    pub report: InstanceReport,
}

/// Minimises E of all active instances in lockstep. Everything is kept from step to step, so that a
/// step allocates nothing.
#[derive(Default)]
pub(super) struct Newton {
    /// One for each instance.
    pub minimisations: Vec<Minimisation>,
    /// The iterates: the prediction before, the result after.
    pub states: Vec<State>,
    /// Which instances take part.
    pub active: Vec<bool>,
    pub(super) running: Vec<bool>,
    evaluations: Vec<Evaluation>,
    /// A second set, for comparing the two possible starts.
    others: Vec<Evaluation>,
    other_states: Vec<State>,
    rising: Vec<bool>,
    /// Energies of the predictions of rising instances, J.
    predicted: Vec<f64>,
    pub(super) search: super::line_search::LineSearch,
}

impl Newton {
    /// Room for `count` instances like `rest`, none of them active.
    pub fn new(minimisations: Vec<Minimisation>, rest: &State) -> Self {
        let count = minimisations.len();
        Self {
            minimisations,
            states: vec![rest.clone(); count],
            active: vec![false; count],
            running: vec![false; count],
            evaluations: vec![Evaluation::default(); count],
            others: vec![Evaluation::default(); count],
            other_states: vec![rest.clone(); count],
            rising: vec![false; count],
            predicted: Vec::with_capacity(count),
            search: Default::default(),
        }
    }

    /// Minimises from [`Newton::states`] (the predictions) and leaves the results there.
    pub async fn minimise<P: Potential>(
        &mut self,
        potential: &mut P,
        solver: &mut dyn LinearSolver,
        mode: SolverMode,
        timings: &mut Timings,
    ) -> Result<()> {
        self.running.clone_from(&self.active);
        self.start(potential, timings).await?;
        match mode {
            SolverMode::OneIteration => {
                self.directions(potential, solver, timings)?;
                self.take_short_steps(TRUST_RADIUS, Stop::OneIteration);
                self.line_search(potential, timings).await?;
                self.stop_running(Stop::OneIteration);
                Ok(())
            }
            SolverMode::Converged {
                tolerance,
                max_iterations,
            } => {
                self.iterate(potential, solver, tolerance, max_iterations, timings)
                    .await
            }
        }
    }

    /// Evaluates the predictions; an instance whose prediction raises the energy starts at qⁿ instead,
    /// if that is lower.
    async fn start<P: Potential>(
        &mut self,
        potential: &mut P,
        timings: &mut Timings,
    ) -> Result<()> {
        self.evaluate(potential, timings).await?;
        for i in 0..self.minimisations.len() {
            let energy = self.total_energy(i);
            // A prediction that overflows is a rise as well.
            let quiet = energy <= ENERGY_RESOLUTION;
            self.rising[i] = self.running[i] && !quiet;
        }
        if !self.rising.contains(&true) {
            return Ok(());
        }
        self.exchange_starts();
        std::mem::swap(&mut self.running, &mut self.rising);
        let minimisations = self.minimisations.iter().zip(&self.others);
        self.predicted.clear();
        self.predicted
            .extend(minimisations.map(|(minimisation, e)| {
                e.energies.total() + minimisation.report.skeleton_energies.total()
            }));
        self.evaluate(potential, timings).await?;
        std::mem::swap(&mut self.running, &mut self.rising);
        for i in 0..self.minimisations.len() {
            if self.rising[i] && self.predicted[i] <= self.total_energy(i) {
                // The prediction was the better start after all (pins carry the bones away from qⁿ).
                std::mem::swap(&mut self.states[i], &mut self.other_states[i]);
                std::mem::swap(&mut self.evaluations[i], &mut self.others[i]);
                self.minimisations[i].report.skeleton_energies = self.skeleton_energies(i);
            } else if self.rising[i] {
                self.minimisations[i].report.started_at_current = true;
            }
        }
        Ok(())
    }

    /// Puts the predictions of rising instances aside, with their evaluations, and qⁿ in their place.
    fn exchange_starts(&mut self) {
        for i in 0..self.minimisations.len() {
            if self.rising[i] {
                self.other_states[i].clone_from(&self.minimisations[i].fallback);
                std::mem::swap(&mut self.states[i], &mut self.other_states[i]);
                std::mem::swap(&mut self.evaluations[i], &mut self.others[i]);
            }
        }
    }

    /// Newton iterations with a line search.
    async fn iterate<P: Potential>(
        &mut self,
        potential: &mut P,
        solver: &mut dyn LinearSolver,
        tolerance: f64,
        max_iterations: usize,
        timings: &mut Timings,
    ) -> Result<()> {
        for iteration in 1..=max_iterations {
            if iteration > 1 {
                self.evaluate(potential, timings).await?;
            }
            self.directions(potential, solver, timings)?;
            self.take_short_steps(tolerance, Stop::Converged);
            self.line_search(potential, timings).await?;
            if !self.running.contains(&true) {
                return Ok(());
            }
        }
        self.stop_running(Stop::IterationLimit);
        Ok(())
    }

    /// Evaluates tissue and skeleton at the iterates of running instances.
    async fn evaluate<P: Potential>(
        &mut self,
        potential: &mut P,
        timings: &mut Timings,
    ) -> Result<()> {
        let watch = Stopwatch::start();
        potential
            .evaluate(&self.states, &self.running, &mut self.evaluations)
            .await?;
        timings.evaluation += watch.ms();
        let watch = Stopwatch::start();
        for i in 0..self.minimisations.len() {
            if !self.running[i] {
                continue;
            }
            let frames = &self.states[i].frames;
            let evaluation = &mut self.evaluations[i];
            let skeleton = &self.minimisations[i].skeleton;
            skeleton.add_derivatives(frames, &mut evaluation.gradient, &mut evaluation.hessian);
            if potential.hessian_form() == HessianForm::Exact {
                skeleton.add_geometric(frames, &mut evaluation.hessian);
            }
            self.minimisations[i].report.skeleton_energies = self.skeleton_energies(i);
        }
        timings.skeleton += watch.ms();
        Ok(())
    }

    /// E(q) − E(qⁿ) of the skeleton at an instance's iterate.
    fn skeleton_energies(&self, i: usize) -> SkeletonEnergies {
        let minimisation = &self.minimisations[i];
        minimisation
            .skeleton
            .difference(&minimisation.current.frames, &self.states[i].frames)
    }

    /// E(q) − E(qⁿ) at the last evaluated iterate.
    fn total_energy(&self, i: usize) -> f64 {
        self.evaluations[i].energies.total()
            + self.minimisations[i].report.skeleton_energies.total()
    }

    /// Solves for every running instance's Newton step and reports what its evaluation said.
    fn directions<P: Potential>(
        &mut self,
        potential: &P,
        solver: &mut dyn LinearSolver,
        timings: &mut Timings,
    ) -> Result<()> {
        let watch = Stopwatch::start();
        for i in 0..self.minimisations.len() {
            if !self.running[i] {
                continue;
            }
            let (minimisation, evaluation) = (&mut self.minimisations[i], &mut self.evaluations[i]);
            let gradient = &evaluation.gradient;
            let energy =
                evaluation.energies.total() + minimisation.report.skeleton_energies.total();
            if !energy.is_finite() {
                return Err(Error::NotFinite { quantity: "energy" });
            }
            if !gradient.iter().all(|g| g.is_finite()) {
                return Err(Error::NotFinite { quantity: "force" });
            }
            let (solved, dropped) = solve(
                solver,
                evaluation,
                &minimisation.fixed,
                &mut minimisation.step,
            )?;
            let gradient = &evaluation.gradient;
            if !minimisation.step.iter().all(|d| d.is_finite()) {
                return Err(Error::NotFinite {
                    quantity: "Newton step",
                });
            }
            if minimisation.fixed.contains(&true) {
                multiply_add(
                    potential.pattern(),
                    &evaluation.hessian,
                    &minimisation.step,
                    gradient,
                    &mut minimisation.reaction,
                );
            }
            let report = &mut minimisation.report;
            report.iterations += 1;
            report.decrement = -dot(gradient, &minimisation.step);
            report.step_length = step_length(&minimisation.step, minimisation.current.frames.len());
            report.diagonal_shift = report.diagonal_shift.max(solved.diagonal_shift);
            report.geometric_dropped += usize::from(dropped);
            report.energies = evaluation.energies;
            report.contact_force = evaluation.contact_force;
            report.contacts = evaluation.contacts;
        }
        timings.solve += watch.ms();
        Ok(())
    }

    /// Moves every running instance whose step is no longer than `length` by its whole step, and ends its
    /// minimisation.
    fn take_short_steps(&mut self, length: f64, stop: Stop) {
        for i in 0..self.minimisations.len() {
            if self.running[i] && self.minimisations[i].report.step_length <= length {
                self.states[i].move_by(&self.minimisations[i].step, 1.0);
                self.minimisations[i].report.stop = stop;
                self.running[i] = false;
            }
        }
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

/// Solves with the geometric terms of contact where the evaluation has them; where the Hessian is not positive definite
/// with them, without. [`Evaluation::hessian`] is then the matrix that served. Tells whether terms were dropped.
fn solve(
    solver: &mut dyn LinearSolver,
    evaluation: &mut Evaluation,
    fixed: &[bool],
    step: &mut [f64],
) -> Result<(SolveReport, bool)> {
    let Evaluation {
        hessian,
        geometric,
        gradient,
        ..
    } = evaluation;
    let wanted = !geometric.is_empty();
    if wanted {
        let sums = geometric.as_flattened_mut().iter_mut();
        for (sum, term) in sums.zip(hessian.as_flattened()) {
            *sum += term;
        }
        if let Ok(report) = solver.solve_shifted(geometric, gradient, fixed, step, &[0.0]) {
            std::mem::swap(hessian, geometric);
            return Ok((report, false));
        }
    }
    Ok((solver.solve(hessian, gradient, fixed, step)?, wanted))
}

/// a · b.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The longest move of a joint or handle, m, rotations counted at [`ROTATION_LEVER`].
fn step_length(step: &[f64], frames: usize) -> f64 {
    let length = |(block, d): (usize, &[f64])| {
        let rotation = block < 2 * frames && block % 2 == 1;
        dot(d, d).sqrt() * if rotation { ROTATION_LEVER } else { 1.0 }
    };
    step.chunks(3).enumerate().map(length).fold(0.0, f64::max)
}
