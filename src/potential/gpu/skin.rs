//! Positions of the posed skin.

use super::buffers::Buffers;
use super::dispatch::{Batch, workgroups};
use super::stage::{Stage, StagePipelines};
use crate::Result;
use crate::gpu::Kernel;

/// Linear blend skinning of the posed skin.
#[derive(Debug)]
pub(super) struct Skin {
    skin: Kernel,
    groups: u32,
}

impl Stage for Skin {
    const INCLUDES: &'static [&'static str] = &[
        "shared/batch.wgsl",
        "shared/kinematics.wgsl",
        "shared/point_motion.wgsl",
    ];

    fn new(pipelines: &StagePipelines, buffers: &Buffers) -> Result<Self> {
        Ok(Self {
            skin: pipelines.kernel("skin", &buffers.over_posed_skin())?,
            groups: workgroups(buffers.sizes.vertices),
        })
    }

    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.skin, pass, self.groups);
    }
}
