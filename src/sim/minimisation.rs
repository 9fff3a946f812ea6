//! One instance's minimisation of E in a step: its Newton step, and what is told about it.

use super::carried::CarriedBone;
use super::instance::Instance;
use super::linear_solver::{LinearSolver, SolveReport};
use super::report::InstanceReport;
use super::skin_spring::SkinPulls;
use super::spring_bones::Swing;
use crate::model::State;
use crate::potential::{BlockPattern, Evaluation, StepEnd};
use crate::skeleton::{SkeletonEnergies, SkeletonPotential};
use crate::{Error, Result};

/// Lever at which a rotation counts as a length, m.
const ROTATION_LEVER: f64 = 0.1;

/// What the skeleton says of the bones that a step ends with.
#[derive(Debug)]
pub(super) struct SkeletonEnd {
    /// E(q) − E(qⁿ).
    energies: SkeletonEnergies,
    /// ∂E/∂(c, ω) of every frame.
    frame_gradient: Vec<f64>,
}

impl SkeletonEnd {
    /// Room for `frames` frames.
    pub fn new(frames: usize) -> Self {
        Self {
            energies: SkeletonEnergies::default(),
            frame_gradient: vec![0.0; 6 * frames],
        }
    }
}

/// One instance's minimisation of E in a step: its problem, and how far it has got.
pub(super) struct Minimisation {
    /// The skeleton's terms of this step.
    pub skeleton: SkeletonPotential,
    /// Those of springs on the skin.
    pub pulls: SkinPulls,
    /// qⁿ.
    pub current: State,
    /// Which frames are prescribed.
    pub prescribed: Vec<bool>,
    /// Which DoFs are: all six of such a frame.
    pub fixed: Vec<bool>,
    /// Whether there is anything that it might touch.
    pub may_touch: bool,
    /// Bones that are put where their parents end.
    pub carried: Vec<CarriedBone>,
    /// Those of them that swing.
    pub swing: Swing,
    /// The Newton step δ.
    pub step: Vec<f64>,
    /// ∂E/∂(c, ω) of tissue and skeleton where the step ends: at prescribed frames, what holds them.
    pub frame_gradient: Vec<f64>,
    /// What happened.
    pub report: InstanceReport,
    /// How the last solve went.
    pub solved: Result<()>,
}

impl Minimisation {
    /// From `current` on, with nothing prescribed.
    pub fn new(skeleton: SkeletonPotential, current: State) -> Self {
        let dofs = current.space().dofs();
        Self {
            prescribed: vec![false; current.frames.len()],
            skeleton,
            pulls: SkinPulls::default(),
            current,
            fixed: vec![false; dofs],
            may_touch: false,
            carried: Vec::new(),
            swing: Swing::default(),
            step: vec![0.0; dofs],
            frame_gradient: Vec::new(),
            report: InstanceReport::default(),
            solved: Ok(()),
        }
    }

    /// Frame `frame` is where it is told to be in this step.
    pub fn prescribe(&mut self, frame: usize) {
        self.prescribed[frame] = true;
        self.fixed[6 * frame..6 * frame + 6].fill(true);
    }

    /// Handles from `first` on stand for fine ones: those that sleep or leave do not move in this step.
    pub fn hold_sleeping(&mut self, first: usize, instance: &Instance) {
        let (frames, taken) = (self.prescribed.len(), instance.awake.handles().len());
        let handles = instance.state.handles.len();
        for slot in 0..handles - first {
            if slot >= taken || instance.waking.is_leaving(slot) {
                let block = 2 * frames + first + slot;
                self.fixed[3 * block..3 * block + 3].fill(true);
            }
        }
    }

    /// Solves H δ = −g for the Newton step, where the iterate has the energies, gradient and Hessian of `evaluation`
    /// (the skeleton's included, whose energies are `skeleton_energies`), and reports on the iteration.
    pub fn solve(
        &mut self,
        solver: &mut dyn LinearSolver,
        evaluation: &mut Evaluation,
        skeleton_energies: SkeletonEnergies,
    ) -> Result<()> {
        check(evaluation, skeleton_energies)?;
        let (solved, dropped) = newton_step(solver, evaluation, &self.fixed, &mut self.step)?;
        self.report.geometric_dropped += usize::from(dropped);
        self.finish(evaluation, skeleton_energies, solved)
    }

    /// Reports on the iteration whose Newton step has been solved for.
    pub fn finish(
        &mut self,
        evaluation: &Evaluation,
        skeleton_energies: SkeletonEnergies,
        solved: SolveReport,
    ) -> Result<()> {
        if !self.step.iter().all(|d| d.is_finite()) {
            return Err(Error::NotFinite {
                quantity: "Newton step",
            });
        }
        let gradient = &evaluation.gradient;
        let report = &mut self.report;
        report.iterations += 1;
        report.decrement = -dot(gradient, &self.step);
        report.step_length = step_length(&self.step, self.current.frames.len());
        report.diagonal_shift = report.diagonal_shift.max(solved.diagonal_shift);
        report.energies = evaluation.energies;
        report.skeleton_energies = skeleton_energies;
        report.contact_force = evaluation.contact_force;
        report.contacts = evaluation.contacts;
        report.contacts_left_out = evaluation.contacts_left_out;
        Ok(())
    }

    /// E(state) − E(base) of what is added on the host: the skeleton's terms and those of springs on the skin.
    pub fn skeleton_difference(&self, base: &State, state: &State) -> SkeletonEnergies {
        let mut energies = self.skeleton.difference(&base.frames, &state.frames);
        energies.tracking += self.pulls.difference(base, state);
        energies
    }

    /// Adds the gradient and the Hessian of the same at `state`, an `exact` one or Gauss–Newton's.
    pub fn add_derivatives(
        &self,
        state: &State,
        exact: bool,
        gradient: &mut [f64],
        hessian: &mut [[f64; 9]],
        pattern: &BlockPattern,
    ) {
        (self.skeleton).add_derivatives(&state.frames, gradient, hessian, pattern);
        (self.pulls).add_derivatives(state, gradient, hessian, pattern);
        if exact {
            (self.skeleton).add_geometric(&state.frames, hessian, pattern);
            self.pulls.add_geometric(state, hessian, pattern);
        }
    }

    /// What the skeleton and springs on the skin say of the bones that the step ends with.
    pub fn skeleton_end(&self, state: &State, out: &mut SkeletonEnd) {
        out.energies = self.skeleton_difference(&self.current, state);
        out.frame_gradient.fill(0.0);
        (self.skeleton).add_gradient(&state.frames, &mut out.frame_gradient);
        self.pulls.add_gradient(state, &mut out.frame_gradient);
    }

    /// Reports on the state that a step ends with, of which skeleton and tissue say this.
    pub fn end(&mut self, skeleton: &SkeletonEnd, end: &StepEnd) {
        self.frame_gradient.clone_from(&end.frame_gradient);
        let sums = self.frame_gradient.iter_mut();
        (sums.zip(&skeleton.frame_gradient)).for_each(|(sum, of_skeleton)| *sum += of_skeleton);
        let report = &mut self.report;
        report.energies = end.energies;
        report.skeleton_energies = skeleton.energies;
        report.contact_force = end.contact_force;
        report.contacts = end.contacts;
        report.contacts_left_out = end.contacts_left_out;
    }
}

/// An error unless a Newton step can be made from an evaluation.
pub(super) fn check(evaluation: &Evaluation, skeleton_energies: SkeletonEnergies) -> Result<()> {
    let energy = evaluation.energies.total() + skeleton_energies.total();
    if !energy.is_finite() {
        return Err(Error::NotFinite { quantity: "energy" });
    }
    if !evaluation.gradient.iter().all(|g| g.is_finite()) {
        return Err(Error::NotFinite { quantity: "force" });
    }
    Ok(())
}

/// Solves with the geometric terms of contact where the evaluation has them; where the Hessian is not positive definite
/// with them, without. [`Evaluation::hessian`] is then the matrix that served. Tells whether terms were dropped.
fn newton_step(
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
fn dot(a: &[f64], b: &[f64]) -> f64 {
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
