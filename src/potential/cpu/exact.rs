//! The f64 evaluation with exact Hessians, which converges quadratically: for studies.

use super::{Basis, CpuPotential};
use crate::Result;
use crate::model::{Awake, BasisEntry, Space, State};
use crate::potential::{
    BlockPattern, Difference, Evaluation, EvaluationTimings, HessianForm, Potential, PreviousSkin,
    StepEnd, StepStart, Trial,
};
use glam::DVec3;

/// A [`CpuPotential`] whose Hessians hold all second derivatives, and may be indefinite far from a minimum. They are
/// assembled densely: some tens of times slower than the solver's.
pub struct Exact<B: Basis = BasisEntry>(pub CpuPotential<B>);

impl<B: Basis> Potential for Exact<B> {
    fn name(&self) -> String {
        format!("{}, exact Hessian", self.0.name())
    }

    fn space(&self) -> Space {
        self.0.space()
    }

    fn pattern(&self) -> &BlockPattern {
        self.0.pattern()
    }

    fn instances(&self) -> usize {
        self.0.instances()
    }

    fn hessian_form(&self) -> HessianForm {
        HessianForm::Exact
    }

    fn timings(&self) -> EvaluationTimings {
        self.0.timings()
    }

    fn wake(&mut self, instance: usize, awake: &Awake) -> Result<()> {
        self.0.wake(instance, awake)
    }

    async fn begin_step(&mut self, starts: &[StepStart<'_>], active: &[bool]) -> Result<()> {
        self.0.begin_step(starts, active).await
    }

    async fn evaluate(
        &mut self,
        states: &[State],
        active: &[bool],
        out: &mut [Evaluation],
    ) -> Result<()> {
        self.0.evaluate(states, active, out).await?;
        for i in (0..states.len()).filter(|&i| active[i]) {
            let dense = self.0.dense_hessian(i, &states[i], HessianForm::Exact)?;
            let blocks = self.0.pattern().blocks().zip(&mut out[i].hessian);
            for ((row, column), block) in blocks {
                // Those of prescribed frames stay zero.
                if !self.0.is_prescribed(i, row) && !self.0.is_prescribed(i, column) {
                    *block = std::array::from_fn(|k| dense[3 * row + k % 3][3 * column + k / 3]);
                }
            }
            // They are in it already.
            out[i].geometric.clear();
        }
        Ok(())
    }

    async fn end_step(
        &mut self,
        states: &[State],
        wanted: &[bool],
        out: &mut [StepEnd],
    ) -> Result<()> {
        self.0.end_step(states, wanted, out).await
    }

    async fn energy_differences(
        &mut self,
        trials: &[Trial<'_>],
        out: &mut [Difference],
    ) -> Result<()> {
        self.0.energy_differences(trials, out).await
    }

    async fn pose_skin(
        &mut self,
        states: &[State],
        offsets: &[&[[f32; 3]]],
        previous: &[PreviousSkin],
    ) -> Result<()> {
        self.0.pose_skin(states, offsets, previous).await
    }

    async fn read_skin(
        &mut self,
        instance: usize,
        positions: &mut Vec<DVec3>,
        normals: &mut Vec<DVec3>,
    ) -> Result<()> {
        self.0.read_skin(instance, positions, normals).await
    }

    async fn read_contacts(
        &mut self,
        instance: usize,
        state: &State,
        forces: &mut Vec<DVec3>,
        pressures: &mut Vec<f64>,
    ) -> Result<()> {
        self.0
            .read_contacts(instance, state, forces, pressures)
            .await
    }
}
