//! Distances of the skin's vertices from the colliders.

use super::buffers::Buffers;
use super::sources::SHAPES;
use super::{Batch, Sources, WORKGROUP};
use crate::Result;
use crate::gpu::Kernel;

pub(super) const INCLUDES: &[&str] = &[
    "shared/batch.wgsl",
    "shared/kinematics.wgsl",
    "shared/point_motion.wgsl",
    "shared/distance.wgsl",
    "shared/contact.wgsl",
    SHAPES,
    "contact.wgsl",
];

/// Depth and normal of every vertex at every collider.
#[derive(Debug)]
pub(super) struct Contact {
    contact: Kernel,
    lagged: Kernel,
    groups: u32,
}

impl Contact {
    pub fn new(device: &wgpu::Device, sources: &Sources, buffers: &Buffers) -> Result<Self> {
        let module = sources.module("contact", INCLUDES)?;
        Ok(Self {
            contact: module.kernel(device, "contact", &buffers.over_skin())?,
            lagged: module.kernel(device, "contact", &buffers.over_lagged_skin())?,
            groups: (buffers.skin.points.len() as u32).div_ceil(WORKGROUP),
        })
    }

    /// For the starts, against the colliders of tⁿ.
    pub fn dispatch_lagged(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.lagged, pass, self.groups);
    }

    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.contact, pass, self.groups);
    }
}
