//! The contacts of a step's start that have friction, and their slip.

use super::buffers::Buffers;
use super::dispatch::{Batch, workgroups};
use super::stage::{Stage, StagePipelines};
use crate::Result;
use crate::gpu::Kernel;

/// Lists the lagged contacts at a step's start; measures their slip in every state.
#[derive(Debug)]
pub(super) struct Friction {
    lag: Kernel,
    anchor: Kernel,
    slip: Kernel,
    groups: u32,
}

impl Stage for Friction {
    const INCLUDES: &'static [&'static str] = &[
        "shared/batch.wgsl",
        "shared/kinematics.wgsl",
        "shared/point_motion.wgsl",
        "shared/contact.wgsl",
        "shared/contact_stiffness.wgsl",
        "shared/friction.wgsl",
        "shared/exclusive_sum.wgsl",
    ];

    fn new(pipelines: &StagePipelines, buffers: &Buffers) -> Result<Self> {
        let kernel = |entry| pipelines.kernel(entry, &buffers.over_lagged_skin());
        Ok(Self {
            lag: kernel("lag")?,
            anchor: kernel("anchor")?,
            slip: kernel("slip")?,
            groups: workgroups(buffers.sizes.contacts),
        })
    }

    /// The slip of the states.
    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.slip, pass, self.groups);
    }
}

impl Friction {
    /// After the lagged distances, for the starts.
    pub fn dispatch_lag(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.lag, pass, 1);
        batch.dispatch(&self.anchor, pass, self.groups);
    }
}
