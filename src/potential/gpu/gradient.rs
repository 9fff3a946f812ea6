//! ∂E/∂q: point by point, then block by block.

use super::buffers::Buffers;
use super::dispatch::{Batch, workgroups};
use super::stage::{Stage, StagePipelines};
use crate::Result;
use crate::gpu::Kernel;

/// The gradient of points and contacts.
#[derive(Debug)]
pub(super) struct Gradient {
    point_gradient: Kernel,
    gradient: Kernel,
    groups: u32,
    blocks: u32,
    frame_blocks: u32,
}

impl Gradient {
    /// By frames alone, for which stresses do not matter.
    pub fn dispatch_frames(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.point_gradient, pass, self.groups);
        batch.dispatch(&self.gradient, pass, self.frame_blocks);
    }
}

impl Stage for Gradient {
    const INCLUDES: &'static [&'static str] = &[
        "shared/batch.wgsl",
        "shared/kinematics.wgsl",
        "shared/contact.wgsl",
    ];

    fn new(pipelines: &StagePipelines, buffers: &Buffers) -> Result<Self> {
        let kernel = |entry| pipelines.kernel(entry, &buffers.over_cubature());
        Ok(Self {
            point_gradient: kernel("point_gradient")?,
            gradient: kernel("gradient")?,
            groups: workgroups(buffers.sizes.points),
            blocks: buffers.sizes.blocks as u32,
            frame_blocks: 2 * buffers.sizes.bones as u32,
        })
    }

    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.point_gradient, pass, self.groups);
        batch.dispatch(&self.gradient, pass, self.blocks);
    }
}
