//! The packed Hessian, gathered from points and contacts.

use super::buffers::Buffers;
use super::dispatch::{Batch, workgroups};
use super::stage::{Stage, StagePipelines};
use crate::Result;
use crate::gpu::Kernel;

/// The stored blocks of the Hessian, the terms of each in as many threads as its segments.
#[derive(Debug)]
pub(super) struct Hessian {
    hessian: Kernel,
    groups: u32,
}

impl Stage for Hessian {
    const INCLUDES: &'static [&'static str] = &["shared/batch.wgsl", "shared/contact.wgsl"];

    fn new(pipelines: &StagePipelines, buffers: &Buffers) -> Result<Self> {
        Ok(Self {
            hessian: pipelines.kernel("hessian", &buffers.over_cubature())?,
            groups: workgroups(buffers.sizes.hessian_segments),
        })
    }

    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.hessian, pass, self.groups);
    }
}
