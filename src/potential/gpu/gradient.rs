//! ∂E/∂q: point by point, then block by block.

use super::buffers::Buffers;
use super::{Batch, Sources, WORKGROUP};
use crate::Result;
use crate::gpu::Kernel;

pub(super) const INCLUDES: &[&str] = &[
    "shared/batch.wgsl",
    "shared/kinematics.wgsl",
    "shared/contact.wgsl",
    "gradient.wgsl",
];

/// The gradient of points and contacts.
#[derive(Debug)]
pub(super) struct Gradient {
    point_gradient: Kernel,
    gradient: Kernel,
    groups: u32,
    blocks: u32,
}

impl Gradient {
    pub fn new(
        device: &wgpu::Device,
        sources: &Sources,
        buffers: &Buffers,
        blocks: usize,
    ) -> Result<Self> {
        let module = sources.module("gradient", INCLUDES)?;
        let kernel = |entry| module.kernel(device, entry, &buffers.over_cubature());
        Ok(Self {
            point_gradient: kernel("point_gradient")?,
            gradient: kernel("gradient")?,
            groups: (buffers.cubature.points.len() as u32).div_ceil(WORKGROUP),
            blocks: blocks as u32,
        })
    }

    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.point_gradient, pass, self.groups);
        batch.dispatch(&self.gradient, pass, self.blocks);
    }
}
