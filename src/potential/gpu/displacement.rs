//! d = x(q) − x(q_base) at the cubature points.

use super::buffers::Buffers;
use super::dispatch::{Batch, workgroups};
use super::stage::{Stage, StagePipelines};
use crate::Result;
use crate::gpu::Kernel;

/// Motion of the cubature points.
#[derive(Debug)]
pub(super) struct Displacement {
    displacement: Kernel,
    groups: u32,
}

impl Stage for Displacement {
    const INCLUDES: &'static [&'static str] = &[
        "shared/batch.wgsl",
        "shared/kinematics.wgsl",
        "shared/point_motion.wgsl",
    ];

    fn new(pipelines: &StagePipelines, buffers: &Buffers) -> Result<Self> {
        Ok(Self {
            displacement: pipelines.kernel("displacement", &buffers.over_cubature())?,
            groups: workgroups(buffers.sizes.points),
        })
    }

    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.displacement, pass, self.groups);
    }
}
