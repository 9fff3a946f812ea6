//! d = x(q) − x(q_base) at the cubature points.

use super::buffers::Buffers;
use super::{Batch, Sources, WORKGROUP};
use crate::Result;
use crate::gpu::Kernel;

pub(super) const INCLUDES: &[&str] = &[
    "shared/batch.wgsl",
    "shared/kinematics.wgsl",
    "shared/point_motion.wgsl",
    "displacement.wgsl",
];

/// Motion of the cubature points.
#[derive(Debug)]
pub(super) struct Displacement {
    displacement: Kernel,
    groups: u32,
}

impl Displacement {
    pub fn new(device: &wgpu::Device, sources: &Sources, buffers: &Buffers) -> Result<Self> {
        let module = sources.module("displacement", INCLUDES)?;
        Ok(Self {
            displacement: module.kernel(device, "displacement", &buffers.over_cubature())?,
            groups: (buffers.cubature.points.len() as u32).div_ceil(WORKGROUP),
        })
    }

    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.displacement, pass, self.groups);
    }
}
