//! Normals of the posed skin.

use super::buffers::Buffers;
use super::dispatch::{Batch, workgroups};
use super::stage::Stage;
use crate::Result;
use crate::gpu::{Kernel, Module};

/// Area-weighted vertex normals.
#[derive(Debug)]
pub(super) struct Normals {
    normals: Kernel,
    groups: u32,
}

impl Stage for Normals {
    const INCLUDES: &'static [&'static str] = &["shared/batch.wgsl"];

    fn new(device: &wgpu::Device, module: &Module, buffers: &Buffers) -> Result<Self> {
        Ok(Self {
            normals: module.kernel(device, "normals", &buffers.over_skin())?,
            groups: workgroups(buffers.sizes.vertices),
        })
    }

    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.normals, pass, self.groups);
    }
}
