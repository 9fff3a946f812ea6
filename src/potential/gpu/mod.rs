//! The potential on the GPU, in the order in which the data flows; a file imports only files named before it.
//!
//! - **What the kernels see.** [`shared`] has the structs that both sides read, `pack` makes them of the model's f64
//!   numbers, `tables` holds those of an avatar that never change.
//! - **What the device holds.** `stage_list` names the stages, `sources` composes their texts, `options` is what a host
//!   chooses, `dispatch` is a batch of states and its chunks, `sizes` says how many of what there are, `grids` and
//!   `buffers` are the memory.
//! - **The stages.** `stage` is what they have in common; then one file a kernel; `stages` is all of them.
//! - **A step.** `potential` is what is made once, `upload` sends states, `begin_step`, `geometric` and `evaluate`,
//!   `end_step`, `energy_differences` and `pose_skin` submit the stages and read back; `profile` times them one by one.

// What the kernels see.
mod pack;
pub mod shared;
mod tables;

// What the device holds.
mod buffers;
mod dispatch;
mod grids;
mod options;
mod sizes;
mod sources;
mod stage_list;

// The stages, one line each here and in `stage_list`.
mod compact;
mod contact;
mod displacement;
mod elasticity;
mod energy;
mod friction;
mod gradient;
mod hessian;
mod normals;
mod point_hessian;
mod pose_blend;
mod select;
mod skin;
mod stage;
mod stages;

// A step.
mod begin_step;
mod end_step;
mod energy_differences;
mod evaluate;
mod geometric;
mod pose_skin;
mod potential;
mod profile;
mod upload;

pub use options::GpuOptions;
pub use potential::GpuPotential;
pub use sources::Sources;
pub use stages::modules;

use crate::Result;
use crate::model::{Space, State};
use crate::potential::{BlockPattern, Evaluation, Potential, StepEnd, StepStart, Trial};
use glam::DVec3;

impl Potential for GpuPotential {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn space(&self) -> Space {
        self.avatar.space()
    }

    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn instances(&self) -> usize {
        self.starts.len()
    }

    async fn begin_step(&mut self, starts: &[StepStart<'_>], active: &[bool]) -> Result<()> {
        begin_step::begin_step(self, starts, active).await
    }

    async fn evaluate(
        &mut self,
        states: &[State],
        active: &[bool],
        out: &mut [Evaluation],
    ) -> Result<()> {
        evaluate::evaluate(self, states, active, out).await
    }

    async fn end_step(
        &mut self,
        states: &[State],
        wanted: &[bool],
        out: &mut [StepEnd],
    ) -> Result<()> {
        end_step::end_step(self, states, wanted, out).await
    }

    async fn energy_differences(&mut self, trials: &[Trial<'_>], out: &mut [f64]) -> Result<()> {
        energy_differences::energy_differences(self, trials, out).await
    }

    async fn pose_skin(&mut self, states: &[State]) -> Result<()> {
        pose_skin::pose_skin(self, states).await
    }

    async fn read_skin(
        &mut self,
        instance: usize,
        positions: &mut Vec<DVec3>,
        normals: &mut Vec<DVec3>,
    ) -> Result<()> {
        pose_skin::read_skin(self, instance, positions, normals).await
    }
}
