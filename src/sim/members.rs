//! What a minimisation is over: the instances of one asset, or those of several in one list.

use crate::Result;
use crate::model::State;
use crate::potential::{
    Difference, Evaluation, HessianForm, Potential, PreviousSkin, StepEnd, StepStart, Trial,
};
use std::future::Future;

/// Instances in one flat list, which are evaluated together. Its methods are those of [`Potential`].
pub(crate) trait Members {
    /// Which Hessian [`Members::evaluate`] gives of a member.
    fn hessian_form(&self, member: usize) -> HessianForm;

    /// Starts a step of every active member.
    fn begin_step(
        &mut self,
        starts: &[StepStart<'_>],
        active: &[bool],
    ) -> impl Future<Output = Result<()>>;

    /// Energy, gradient and Hessian of every member that is `wanted`.
    fn evaluate(
        &mut self,
        states: &[State],
        wanted: &[bool],
        out: &mut [Evaluation],
    ) -> impl Future<Output = Result<()>>;

    /// What the states that the step ends with tell of every `wanted` member. Where `late` is set, it may be what the step
    /// before ended with, which is known sooner; it is cleared where it is not.
    fn end_step(
        &mut self,
        states: &[State],
        wanted: &[bool],
        out: &mut [StepEnd],
        late: &mut [bool],
    ) -> impl Future<Output = Result<()>>;

    /// E(state) − E(base) of each trial.
    fn energy_differences(
        &mut self,
        trials: &[Trial<'_>],
        out: &mut [Difference],
    ) -> impl Future<Output = Result<()>>;

    /// Poses the drawn skin of every member.
    fn pose_skin(
        &mut self,
        states: &[State],
        offsets: &[&[[f32; 3]]],
        previous: &[PreviousSkin],
    ) -> impl Future<Output = Result<()>>;
}

impl<P: Potential> Members for P {
    fn hessian_form(&self, _member: usize) -> HessianForm {
        Potential::hessian_form(self)
    }

    fn begin_step(
        &mut self,
        starts: &[StepStart<'_>],
        active: &[bool],
    ) -> impl Future<Output = Result<()>> {
        Potential::begin_step(self, starts, active)
    }

    fn evaluate(
        &mut self,
        states: &[State],
        wanted: &[bool],
        out: &mut [Evaluation],
    ) -> impl Future<Output = Result<()>> {
        Potential::evaluate(self, states, wanted, out)
    }

    fn end_step(
        &mut self,
        states: &[State],
        wanted: &[bool],
        out: &mut [StepEnd],
        late: &mut [bool],
    ) -> impl Future<Output = Result<()>> {
        late.fill(false);
        Potential::end_step(self, states, wanted, out)
    }

    fn energy_differences(
        &mut self,
        trials: &[Trial<'_>],
        out: &mut [Difference],
    ) -> impl Future<Output = Result<()>> {
        Potential::energy_differences(self, trials, out)
    }

    fn pose_skin(
        &mut self,
        states: &[State],
        offsets: &[&[[f32; 3]]],
        previous: &[PreviousSkin],
    ) -> impl Future<Output = Result<()>> {
        Potential::pose_skin(self, states, offsets, previous)
    }
}
