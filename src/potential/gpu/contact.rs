//! Distances of the skin's vertices from the colliders.

use super::buffers::Buffers;
use super::dispatch::{Batch, workgroups};
use super::sources::SHAPES;
use super::stage::{Stage, StagePipelines};
use crate::Result;
use crate::gpu::Kernel;

/// Depth and normal of every vertex at every collider.
#[derive(Debug)]
pub(super) struct Contact {
    contact: Kernel,
    lagged: Kernel,
    groups: u32,
}

impl Stage for Contact {
    const INCLUDES: &'static [&'static str] = &[
        "shared/batch.wgsl",
        "shared/kinematics.wgsl",
        "shared/point_motion.wgsl",
        "shared/distance.wgsl",
        "shared/contact.wgsl",
        SHAPES,
    ];

    fn new(pipelines: &StagePipelines, buffers: &Buffers) -> Result<Self> {
        Ok(Self {
            contact: pipelines.kernel("contact", &buffers.over_skin())?,
            lagged: pipelines.kernel("contact", &buffers.over_lagged_skin())?,
            groups: workgroups(buffers.sizes.vertices),
        })
    }

    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.contact, pass, self.groups);
    }
}

impl Contact {
    /// For the starts, against the colliders of tⁿ.
    pub fn dispatch_lagged(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.lagged, pass, self.groups);
    }
}
