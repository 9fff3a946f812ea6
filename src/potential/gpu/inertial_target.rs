//! ŷ of the cubature points.

use super::buffers::Buffers;
use super::dispatch::{Batch, workgroups};
use super::stage::{Stage, StagePipelines};
use crate::Result;
use crate::gpu::Kernel;

/// Where inertia would move the cubature points from a step's start.
#[derive(Debug)]
pub(super) struct InertialTarget {
    inertial_target: Kernel,
    groups: u32,
}

impl Stage for InertialTarget {
    const INCLUDES: &'static [&'static str] = &["shared/batch.wgsl", "shared/kinematics.wgsl"];

    fn new(pipelines: &StagePipelines, buffers: &Buffers) -> Result<Self> {
        Ok(Self {
            inertial_target: pipelines.kernel("inertial_target", &buffers.over_cubature())?,
            groups: workgroups(buffers.sizes.points),
        })
    }

    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.inertial_target, pass, self.groups);
    }
}
