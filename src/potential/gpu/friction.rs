//! The contacts of a step's start that rub, and how they have slid.

use super::buffers::Buffers;
use super::{Batch, Sources, WORKGROUP};
use crate::Result;
use crate::gpu::Kernel;

pub(super) const INCLUDES: &[&str] = &[
    "shared/batch.wgsl",
    "shared/kinematics.wgsl",
    "shared/point_motion.wgsl",
    "shared/contact.wgsl",
    "shared/friction.wgsl",
    "shared/exclusive_sum.wgsl",
    "friction.wgsl",
];

/// Lists the lagged contacts at a step's start; measures their slip in every state.
#[derive(Debug)]
pub(super) struct Friction {
    lag: Kernel,
    anchor: Kernel,
    slip: Kernel,
    groups: u32,
}

impl Friction {
    pub fn new(
        device: &wgpu::Device,
        sources: &Sources,
        buffers: &Buffers,
        contacts: usize,
    ) -> Result<Self> {
        let module = sources.module("friction", INCLUDES)?;
        let kernel = |entry| module.kernel(device, entry, &buffers.over_lagged_skin());
        Ok(Self {
            lag: kernel("lag")?,
            anchor: kernel("anchor")?,
            slip: kernel("slip")?,
            groups: (contacts as u32).div_ceil(WORKGROUP),
        })
    }

    /// After the lagged distances, for the starts.
    pub fn dispatch_lag(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.lag, pass, 1);
        batch.dispatch(&self.anchor, pass, self.groups);
    }

    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.slip, pass, self.groups);
    }
}
