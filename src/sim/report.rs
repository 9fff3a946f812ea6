//! What a step tells about itself.

use crate::potential::Energies;
use crate::skeleton::SkeletonEnergies;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Every way in which Newton's method stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Stop {
    /// The one iteration of [`SolverMode::OneIteration`](super::SolverMode::OneIteration) was made.
    OneIteration,
    /// The last step lowered E as the model said that it would, or was too short to be doubted
    /// ([`SolverMode::Budgeted`](super::SolverMode::Budgeted)).
    AsModelled,
    /// The last step was shorter than the tolerance.
    Converged,
    /// No step along the direction lowers the energy by more than it can be resolved.
    LineSearchStalled,
    /// The allowed iterations were used up.
    IterationLimit,
    /// The instance was not active.
    Inactive,
}

/// Wall-clock time of a step, ms. The first three are the evaluation's own account where it gives one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Timings {
    /// Energies and gradients.
    pub force: f64,
    /// Hessians.
    pub hessian: f64,
    /// Waiting for results of the device.
    pub readback: f64,
    /// All of the potential's work, seen from outside.
    pub evaluation: f64,
    /// The skeleton's terms.
    pub skeleton: f64,
    /// Linear systems.
    pub solve: f64,
    /// Posing the drawn skin.
    pub skin: f64,
    /// The whole step.
    pub step: f64,
}

/// Force and torque that a target or a pin exerts on its bone.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Which bone.
    pub bone: usize,
    /// N, world axes.
    pub force: DVec3,
    /// N·m about the bone's joint, world axes.
    pub torque: DVec3,
}

/// One instance's part of a [`StepReport`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct InstanceReport {
    /// Why the minimisation ended.
    pub stop: Stop,
    /// Newton iterations made.
    pub iterations: usize,
    /// Whether it started with the tissue as it is at qⁿ, because the prediction raised the energy.
    pub started_at_current: bool,
    /// Newton's decrement −gᵀδ of the last iteration, J.
    pub decrement: f64,
    /// Length of the last Newton step, m.
    pub step_length: f64,
    /// Largest diagonal shift that a factorisation needed, relative to the scaled diagonal of 1.
    pub diagonal_shift: f64,
    /// Iterations whose Hessian was positive definite only without the geometric terms of contact, see
    /// [`Settings::geometric_contact`](super::Settings::geometric_contact).
    #[serde(default)]
    pub geometric_dropped: usize,
    /// E(q) − E(qⁿ), J. This and what follows is of the state that the step ends with where a bone is pinned or
    /// [`Settings::report_at_end`](super::Settings::report_at_end) is set, else of the iterate that was evaluated last: after
    /// one iteration that is the prediction, whose contacts may be far from those of the end. A [`World`](crate::World) on the
    /// GPU says it of the step before.
    pub energies: Energies,
    /// The same of the skeleton's terms.
    pub skeleton_energies: SkeletonEnergies,
    /// Sum of the contact forces on the skin, N.
    pub contact_force: DVec3,
    /// Active contacts.
    pub contacts: usize,
    /// Contacts for which the evaluation has no room ([`Evaluation::contacts_left_out`]).
    ///
    /// [`Evaluation::contacts_left_out`]: crate::potential::Evaluation::contacts_left_out
    pub contacts_left_out: usize,
    /// Largest distance between the two sides of a joint, m.
    pub max_joint_gap: f64,
    /// What targets and pins exert at the step's end. A pin's is ∂E/∂q there: contact, weight, the change of momentum, and
    /// what neighbouring bones put on it.
    pub loads: Vec<Load>,
    /// Weight of bones and tissue, N.
    pub weight: DVec3,
}

impl Default for InstanceReport {
    fn default() -> Self {
        Self {
            stop: Stop::Inactive,
            iterations: 0,
            started_at_current: false,
            decrement: 0.0,
            step_length: 0.0,
            diagonal_shift: 0.0,
            geometric_dropped: 0,
            energies: Energies::default(),
            skeleton_energies: SkeletonEnergies::default(),
            contact_force: DVec3::ZERO,
            contacts: 0,
            contacts_left_out: 0,
            max_joint_gap: 0.0,
            loads: Vec::new(),
            weight: DVec3::ZERO,
        }
    }
}

impl InstanceReport {
    /// As [`InstanceReport::default`], in the same memory.
    pub(super) fn reset(&mut self) {
        let mut loads = std::mem::take(&mut self.loads);
        loads.clear();
        *self = Self {
            loads,
            ..Self::default()
        };
    }
}

/// What [`Simulation::step`](super::Simulation::step) did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StepReport {
    /// Wall-clock times of the whole batch.
    pub timings: Timings,
    /// One for each instance.
    pub instances: Vec<InstanceReport>,
}
