//! F, P and the projected C at the cubature points.

use super::buffers::Buffers;
use super::dispatch::{Batch, workgroups};
use super::sources::MATERIAL;
use super::stage::Stage;
use crate::Result;
use crate::gpu::{Kernel, Module};

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

    fn new(device: &wgpu::Device, module: &Module, buffers: &Buffers) -> Result<Self> {
        Ok(Self {
            elasticity: module.kernel(device, "elasticity", &buffers.over_cubature())?,
            groups: workgroups(buffers.sizes.points),
        })
    }

    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.elasticity, pass, self.groups);
    }
}
