//! Which contacts there is room for, chosen at a step's start.

use super::buffers::Buffers;
use super::dispatch::Batch;
use super::stage::{Run, Stage, StagePipelines};
use crate::Result;
use crate::gpu::Kernel;

/// Keeps the deepest pairs of the starts.
#[derive(Debug)]
pub(super) struct Select {
    deepest: Kernel,
    lagged: Kernel,
}

impl Stage for Select {
    const INCLUDES: &'static [&'static str] = &[
        "shared/batch.wgsl",
        "shared/contact.wgsl",
        "shared/exclusive_sum.wgsl",
    ];

    fn new(pipelines: &StagePipelines, buffers: &Buffers) -> Result<Self> {
        Ok(Self {
            deepest: pipelines.kernel("keep_deepest", &buffers.over_skin())?,
            lagged: pipelines.kernel("keep_deepest", &buffers.over_lagged_skin())?,
        })
    }

    /// Nothing: it belongs to no evaluation.
    fn timed(_: &'static str) -> Vec<(&'static str, Run<Self>)> {
        Vec::new()
    }

    /// Of the starts, after their distances.
    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.deepest, pass, 1);
    }
}

impl Select {
    /// Of the starts against the colliders of tⁿ, after the lagged distances.
    pub fn dispatch_lagged(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.lagged, pass, 1);
    }
}
