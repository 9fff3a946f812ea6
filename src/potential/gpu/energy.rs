//! Energy differences, summed in a fixed tree.

use super::buffers::Buffers;
use super::dispatch::{Batch, workgroups};
use super::sources::MATERIAL;
use super::stage::{Stage, StagePipelines};
use crate::Result;
use crate::gpu::Kernel;

/// The energies of points and contacts, and their sums.
#[derive(Debug)]
pub(super) struct Energy {
    point_energy: Kernel,
    contact_energy: Kernel,
    energy: Kernel,
    point_groups: u32,
    vertex_groups: u32,
}

impl Stage for Energy {
    const INCLUDES: &'static [&'static str] = &[
        "shared/batch.wgsl",
        "shared/kinematics.wgsl",
        "shared/tensor.wgsl",
        "shared/decomposition.wgsl",
        "shared/contact.wgsl",
        "shared/contact_stiffness.wgsl",
        "shared/friction.wgsl",
        "shared/tissue.wgsl",
        MATERIAL,
    ];

    fn new(pipelines: &StagePipelines, buffers: &Buffers) -> Result<Self> {
        let (cubature, skin) = (buffers.over_cubature(), buffers.over_skin());
        Ok(Self {
            point_energy: pipelines.kernel("point_energy", &cubature)?,
            contact_energy: pipelines.kernel("contact_energy", &skin)?,
            energy: pipelines.kernel("energy", &cubature)?,
            point_groups: workgroups(buffers.sizes.points),
            vertex_groups: workgroups(buffers.sizes.vertices),
        })
    }

    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.point_energy, pass, self.point_groups);
        batch.dispatch(&self.contact_energy, pass, self.vertex_groups);
        batch.dispatch(&self.energy, pass, 1);
    }
}
