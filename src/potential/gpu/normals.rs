//! Normals of the posed skin.

use super::buffers::Buffers;
use super::dispatch::{Batch, workgroups};
use super::stage::{Stage, StagePipelines};
use crate::Result;
use crate::gpu::Kernel;

/// Area-weighted vertex normals.
#[derive(Debug)]
pub(super) struct Normals {
    normals: Kernel,
    groups: u32,
}

impl Stage for Normals {
    const INCLUDES: &'static [&'static str] = &["shared/batch.wgsl"];

    fn new(pipelines: &StagePipelines, buffers: &Buffers) -> Result<Self> {
        Ok(Self {
            normals: pipelines.kernel("normals", &buffers.over_skin())?,
            groups: workgroups(buffers.sizes.vertices),
        })
    }

    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.normals, pass, self.groups);
    }
}
