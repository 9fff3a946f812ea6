//! The packed Hessian, gathered from points and contacts.

use super::buffers::Buffers;
use super::{Batch, Sources, WORKGROUP};
use crate::Result;
use crate::gpu::Kernel;

pub(super) const INCLUDES: &[&str] = &["shared/batch.wgsl", "shared/contact.wgsl", "hessian.wgsl"];

/// The stored blocks of the Hessian.
#[derive(Debug)]
pub(super) struct Hessian {
    hessian: Kernel,
    groups: u32,
}

impl Hessian {
    pub fn new(device: &wgpu::Device, sources: &Sources, buffers: &Buffers) -> Result<Self> {
        let module = sources.module("hessian", INCLUDES)?;
        Ok(Self {
            hessian: module.kernel(device, "hessian", &buffers.over_cubature())?,
            groups: (buffers.pattern.len() as u32).div_ceil(WORKGROUP),
        })
    }

    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.hessian, pass, self.groups);
    }
}
