//! F, P and the projected C at the cubature points.

use super::buffers::Buffers;
use super::sources::MATERIAL;
use super::{Batch, Sources, WORKGROUP};
use crate::Result;
use crate::gpu::Kernel;

pub(super) const INCLUDES: &[&str] = &[
    "shared/batch.wgsl",
    "shared/kinematics.wgsl",
    "shared/tensor.wgsl",
    "shared/decomposition.wgsl",
    "shared/tissue.wgsl",
    MATERIAL,
    "elasticity.wgsl",
];

/// Stress and tangent of the cubature points.
#[derive(Debug)]
pub(super) struct Elasticity {
    elasticity: Kernel,
    groups: u32,
}

impl Elasticity {
    pub fn new(device: &wgpu::Device, sources: &Sources, buffers: &Buffers) -> Result<Self> {
        let module = sources.module("elasticity", INCLUDES)?;
        Ok(Self {
            elasticity: module.kernel(device, "elasticity", &buffers.over_cubature())?,
            groups: (buffers.cubature.points.len() as u32).div_ceil(WORKGROUP),
        })
    }

    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.elasticity, pass, self.groups);
    }
}
