//! F, P and the projected C at the cubature points.

use super::buffers::Buffers;
use super::dispatch::{Batch, workgroups};
use super::sources::MATERIAL;
use super::stage::{Stage, StagePipelines};
use crate::Result;
use crate::gpu::Kernel;

/// Stress and tangent of the cubature points.
#[derive(Debug)]
pub(super) struct Elasticity {
    elasticity: Kernel,
    groups: u32,
}

impl Stage for Elasticity {
    const INCLUDES: &'static [&'static str] = &[
        "shared/batch.wgsl",
        "shared/kinematics.wgsl",
        "shared/tensor.wgsl",
        "shared/decomposition.wgsl",
        "shared/tissue.wgsl",
        MATERIAL,
    ];

    fn new(pipelines: &StagePipelines, buffers: &Buffers) -> Result<Self> {
        Ok(Self {
            elasticity: pipelines.kernel("elasticity", &buffers.over_cubature())?,
            groups: workgroups(buffers.sizes.points),
        })
    }

    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.elasticity, pass, self.groups);
    }
}
