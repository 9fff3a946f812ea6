//! Normals of the drawn skin.

use super::buffers::Buffers;
use super::{Batch, Sources, WORKGROUP};
use crate::Result;
use crate::gpu::Kernel;

pub(super) const INCLUDES: &[&str] = &["shared/batch.wgsl", "normals.wgsl"];

/// Area-weighted vertex normals.
#[derive(Debug)]
pub(super) struct Normals {
    normals: Kernel,
    groups: u32,
}

impl Normals {
    pub fn new(device: &wgpu::Device, sources: &Sources, buffers: &Buffers) -> Result<Self> {
        let module = sources.module("normals", INCLUDES)?;
        Ok(Self {
            normals: module.kernel(device, "normals", &buffers.over_skin())?,
            groups: (buffers.skin.points.len() as u32).div_ceil(WORKGROUP),
        })
    }

    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.normals, pass, self.groups);
    }
}
