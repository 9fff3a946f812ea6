//! Energy differences, summed in a fixed tree.

use super::buffers::Buffers;
use super::sources::MATERIAL;
use super::{Batch, Sources, WORKGROUP};
use crate::Result;
use crate::gpu::Kernel;

pub(super) const INCLUDES: &[&str] = &[
    "shared/batch.wgsl",
    "shared/kinematics.wgsl",
    "shared/tensor.wgsl",
    "shared/decomposition.wgsl",
    "shared/contact.wgsl",
    "shared/friction.wgsl",
    "shared/tissue.wgsl",
    MATERIAL,
    "energy.wgsl",
];

/// The energies of points and contacts, and their sums.
#[derive(Debug)]
pub(super) struct Energy {
    point_energy: Kernel,
    contact_energy: Kernel,
    energy: Kernel,
    point_groups: u32,
    vertex_groups: u32,
}

impl Energy {
    pub fn new(device: &wgpu::Device, sources: &Sources, buffers: &Buffers) -> Result<Self> {
        let module = sources.module("energy", INCLUDES)?;
        let (cubature, skin) = (buffers.over_cubature(), buffers.over_skin());
        Ok(Self {
            point_energy: module.kernel(device, "point_energy", &cubature)?,
            contact_energy: module.kernel(device, "contact_energy", &skin)?,
            energy: module.kernel(device, "energy", &cubature)?,
            point_groups: (buffers.cubature.points.len() as u32).div_ceil(WORKGROUP),
            vertex_groups: (buffers.skin.points.len() as u32).div_ceil(WORKGROUP),
        })
    }

    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.point_energy, pass, self.point_groups);
        batch.dispatch(&self.contact_energy, pass, self.vertex_groups);
        batch.dispatch(&self.energy, pass, 1);
    }
}
