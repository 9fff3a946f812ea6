//! Positions of the drawn skin.

use super::buffers::Buffers;
use super::{Batch, Sources, WORKGROUP};
use crate::Result;
use crate::gpu::Kernel;

pub(super) const INCLUDES: &[&str] = &[
    "shared/batch.wgsl",
    "shared/kinematics.wgsl",
    "shared/point_motion.wgsl",
    "skin.wgsl",
];

/// Linear blend skinning of the drawn skin.
#[derive(Debug)]
pub(super) struct Skin {
    skin: Kernel,
    groups: u32,
}

impl Skin {
    pub fn new(device: &wgpu::Device, sources: &Sources, buffers: &Buffers) -> Result<Self> {
        let module = sources.module("skin", INCLUDES)?;
        Ok(Self {
            skin: module.kernel(device, "skin", &buffers.over_drawn_skin())?,
            groups: (buffers.skin.points.len() as u32).div_ceil(WORKGROUP),
        })
    }

    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.skin, pass, self.groups);
    }
}
