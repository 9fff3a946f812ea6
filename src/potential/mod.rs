//! The incremental potential of a step, as Newton sees it.
//!
//! `E(q) = E_inertia + E_gravity + E_elastic + E_damping + E_contact + E_friction` of the tissue. The bones' own
//! terms are in [`crate::skeleton`]. Two implementations: the f64 evaluation in [`CpuPotential`], and the WGSL kernels in
//! `GpuPotential`.

pub(crate) mod checks;
pub(crate) mod cpu;
mod factors;
#[cfg(feature = "gpu")]
pub(crate) mod gpu;
pub(crate) mod pattern;

pub use cpu::CpuPotential;
pub use factors::TissueFactors;
#[cfg(feature = "gpu")]
pub(crate) use gpu::Recorder as GpuRecorder;
#[cfg(feature = "gpu")]
pub use gpu::{GpuKernels, GpuOptions, GpuPotential};
pub use pattern::BlockPattern;
#[cfg(feature = "gpu")]
pub(crate) use pattern::point_blocks;

use crate::collider::Collider;
use crate::model::{Awake, InertialTarget, Space, State};
use crate::{Error, Result};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::future::Future;

/// What one instance's step starts from; constant through the step's Newton iterations.
#[derive(Clone, Copy, Debug)]
pub struct StepStart<'a> {
    /// h, s.
    pub time_step: f64,
    /// Where inertia draws to, and how the step differentiates.
    pub inertia: InertialTarget<'a>,
    /// qⁿ: its pose gives x̄ for the whole step, and energies are measured from it.
    pub current: &'a State,
    /// Colliders, each with its frame at tⁿ and at tⁿ⁺¹. Only [`Avatar::body_frames`](crate::model::Avatar::body_frames)
    /// may carry one.
    pub colliders: &'a [Collider],
    /// Gravity on the tissue's displacement, m/s²; zero where the rest shape already sags.
    pub tissue_gravity: DVec3,
    /// ε_v, m/s: friction holds against slower slip only in part, see [`crate::potential::cpu::friction`].
    pub slip_speed: f64,
    /// Whether evaluations hold the geometric terms of contact as well.
    pub geometric_contact: bool,
    /// On the tissue as the avatar has it.
    pub factors: TissueFactors,
    /// u, m: added to x̄ of the skin, and what follows of them to x̄ of the tissue; one for each vertex that
    /// [`Avatar::offset_vertices`](crate::model::Avatar::offset_vertices) counts, or nothing.
    pub pose_offsets: &'a [[f32; 3]],
    /// Which frames are where they are told to be, one for each frame; empty where none is. Blocks of the Hessian in
    /// their rows and columns are zero; the gradient has its part by them all the same.
    pub prescribed: &'a [bool],
}

impl StepStart<'_> {
    /// Whether `frame` is prescribed.
    pub fn is_prescribed(&self, frame: usize) -> bool {
        self.prescribed.get(frame).is_some_and(|p| *p)
    }

    /// Checks the colliders, who carries them, and ε_v.
    pub fn validate_contact(&self, body_frames: &[u32]) -> Result<()> {
        if !(self.slip_speed > 0.0 && self.slip_speed.is_finite()) {
            return Err(Error::invalid(
                "slip_speed",
                format!("{}; must be positive (m/s)", self.slip_speed),
            ));
        }
        for (i, collider) in self.colliders.iter().enumerate() {
            let field = || format!("colliders[{i}]");
            collider.validate().map_err(|e| e.within(&field()))?;
            if let Some(body) = collider.body.filter(|c| !body_frames.contains(c)) {
                return Err(Error::invalid(
                    format!("{}.body", field()),
                    format!(
                        "frame {body} cannot carry a collider: only frames without a parent \
                         that move no tissue can"
                    ),
                ));
            }
        }
        Ok(())
    }
}

/// The energies of the tissue, J. In an [`Evaluation`] each is E(q) − E(qⁿ).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Energies {
    /// Σ m/(2h̃²) |x − x̂|².
    pub inertia: f64,
    /// −Σ m g · x, only where gravity loads the handles.
    pub gravity: f64,
    /// Σ w Ψ(F).
    pub elastic: f64,
    /// Σ w β/(2h̃) (F − F̃) : Cⁿ : (F − F̃).
    pub damping: f64,
    /// Σ ½ k a (d̂ − d)₊².
    pub contact: f64,
    /// Σ μ λ f₀(|u_T|).
    pub friction: f64,
}

impl Energies {
    /// Their sum.
    pub fn total(&self) -> f64 {
        self.inertia + self.gravity + self.elastic + self.damping + self.contact + self.friction
    }
}

/// The potential at one state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Evaluation {
    /// E(q) − E(qⁿ), term by term.
    pub energies: Energies,
    /// ∂E/∂q: [`Space::dofs`] scalars in block order.
    pub gradient: Vec<f64>,
    /// The solver's Hessian: the blocks of [`BlockPattern`] in order, each 3×3 column by column.
    pub hessian: Vec<[f64; 9]>,
    /// Σ f · ∂²z/∂q² of the contacts in the same blocks, see [`crate::potential::cpu::geometric`]; empty where the step
    /// did not ask for it or [`Evaluation::hessian`] has it already.
    pub geometric: Vec<[f64; 9]>,
    /// Sum of the contact and friction forces on the skin, N, in world axes.
    pub contact_force: DVec3,
    /// Active contacts.
    pub contacts: usize,
    /// Contacts for which the implementation has no room: the least deep at the step's start.
    pub contacts_left_out: usize,
}

/// What the potential says of the state that a step ends with.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepEnd {
    /// E(q) − E(qⁿ), term by term.
    pub energies: Energies,
    /// ∂E/∂(c, ω) of every frame, six scalars each: the load that the tissue puts on it, with the sign turned.
    pub frame_gradient: Vec<f64>,
    /// Sum of the contact and friction forces on the skin, N, in world axes.
    pub contact_force: DVec3,
    /// Active contacts.
    pub contacts: usize,
    /// Contacts for which the implementation has no room: the least deep at the step's start.
    pub contacts_left_out: usize,
}

/// A state to be compared with an instance's base state.
#[derive(Clone, Copy, Debug)]
pub struct Trial<'a> {
    /// Which instance.
    pub instance: usize,
    /// Where the difference starts.
    pub base: &'a State,
    /// Where it ends.
    pub state: &'a State,
}

/// What an implementation says of a [`Trial`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Difference {
    /// E(state) − E(base), J. Where it overflows it is not finite.
    pub energy: f64,
    /// Σ |force| of contacts that opened or closed on the way, and of friction that gave way, N: what the quadratic model at
    /// the base does not foresee,
    ///
    /// ```text
    /// Σ k a max(δ, δ_base) of pairs that touch in one of the two states only + Σ |f(u) − f(u_base) − H(u_base) (u − u_base)|
    /// ```
    pub unforeseen_force: f64,
    /// Σ k a δ of all contacts of the state, N.
    pub pressing_force: f64,
}

/// What the previous posed skin of an instance is once another is posed: a renderer draws motion between the two.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PreviousSkin {
    /// What it was: the same moment is posed again.
    Kept,
    /// The one that was posed last: a step has been made.
    Last,
    /// The new one: the instance was put there, and no motion is to be seen.
    New,
}

/// Where an evaluation spent its time since the step began, ms of wall clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct EvaluationTimings {
    /// Energies and gradients.
    pub force: f64,
    /// Hessians.
    pub hessian: f64,
    /// Waiting for results of the device.
    pub readback: f64,
}

/// Which second derivatives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HessianForm {
    /// All of them, symmetrised over the order of two rotations: with the unprojected tangent, the curvature of the
    /// colliders, and fᵀ ∂²x/∂q² of inertia, gravity and contact. May be indefinite.
    Exact,
    /// Gauss–Newton with the projected tangent, as Newton gets it: positive semi-definite.
    Solver,
}

/// The tissue's energy for a batch of avatars of one baked asset.
pub trait Potential {
    /// What evaluates it, for reports: `"cpu"`, or the adapter's name.
    fn name(&self) -> String;

    /// The numbering of DoFs, one for all instances.
    fn space(&self) -> Space;

    /// Which 3×3 blocks of the Hessian there are.
    fn pattern(&self) -> &BlockPattern;

    /// Number of instances.
    fn instances(&self) -> usize;

    /// Which Hessian [`Potential::evaluate`] gives; the skeleton's terms follow.
    fn hessian_form(&self) -> HessianForm {
        HessianForm::Solver
    }

    /// Time spent since the last [`Potential::begin_step`], where the implementation measures it.
    fn timings(&self) -> EvaluationTimings {
        EvaluationTimings::default()
    }

    /// Says which fine handles of an instance are awake in what follows; none at first.
    ///
    /// # Errors
    /// [`Error::Invalid`] where one is not there, and where the implementation has no fine handles.
    fn wake(&mut self, instance: usize, awake: &Awake) -> Result<()> {
        let _ = instance;
        match awake.is_none() {
            true => Ok(()),
            false => Err(Error::invalid(
                "awake",
                format!(
                    "{} evaluates no fine handles: give the avatar no slots for them",
                    self.name()
                ),
            )),
        }
    }

    /// Starts a step of every active instance: x̄ from θⁿ, x̂, the lagged damping tangent.
    fn begin_step(
        &mut self,
        starts: &[StepStart<'_>],
        active: &[bool],
    ) -> impl Future<Output = Result<()>>;

    /// Energy, gradient and Hessian of every active instance; the others' `out` is left alone.
    fn evaluate(
        &mut self,
        states: &[State],
        active: &[bool],
        out: &mut [Evaluation],
    ) -> impl Future<Output = Result<()>>;

    /// Energies, contacts and the gradient by frames at `states`, those that the step ends with, of every `wanted`
    /// instance; the others' `out` is left alone. No second derivative is made, nor what only handles need.
    fn end_step(
        &mut self,
        states: &[State],
        wanted: &[bool],
        out: &mut [StepEnd],
    ) -> impl Future<Output = Result<()>>;

    /// What there is between state and base of each trial, energies summed from increments; `out` is as long as `trials`.
    /// Where it overflows it is not finite: the trial is a bad one, not the call.
    fn energy_differences(
        &mut self,
        trials: &[Trial<'_>],
        out: &mut [Difference],
    ) -> impl Future<Output = Result<()>>;

    /// Poses the drawn skin of every instance, with x̄ of the state's own pose and of its `offsets` (of each instance, or
    /// nothing where none has any), and its normals. They stay where the implementation keeps them (on the GPU: a buffer
    /// to draw from). `previous` says what the previous skin of each instance is then; where it is empty, all are kept.
    fn pose_skin(
        &mut self,
        states: &[State],
        offsets: &[&[[f32; 3]]],
        previous: &[PreviousSkin],
    ) -> impl Future<Output = Result<()>>;

    /// Copies out what [`Potential::pose_skin`] made for an instance: positions (m, world) and normals.
    fn read_skin(
        &mut self,
        instance: usize,
        positions: &mut Vec<DVec3>,
        normals: &mut Vec<DVec3>,
    ) -> impl Future<Output = Result<()>>;

    /// Contact and friction on each vertex of an instance's skin at `state`, in the step that it has begun: force (N, world
    /// axes) and pressure (Pa: the normal force by the vertex's area in the reference shape).
    fn read_contacts(
        &mut self,
        instance: usize,
        state: &State,
        forces: &mut Vec<DVec3>,
        pressures: &mut Vec<f64>,
    ) -> impl Future<Output = Result<()>>;
}
