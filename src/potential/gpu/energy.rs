//! Energy differences, summed in a fixed tree.

use super::buffers::Buffers;
use super::dispatch::{Batch, workgroups};
use super::sources::MATERIAL;
use super::stage::Stage;
use crate::Result;
use crate::gpu::{Kernel, Module};

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
        "shared/friction.wgsl",
        "shared/tissue.wgsl",
        MATERIAL,
    ];

    fn new(device: &wgpu::Device, module: &Module, buffers: &Buffers) -> Result<Self> {
        let (cubature, skin) = (buffers.over_cubature(), buffers.over_skin());
        Ok(Self {
            point_energy: module.kernel(device, "point_energy", &cubature)?,
            contact_energy: module.kernel(device, "contact_energy", &skin)?,
            energy: module.kernel(device, "energy", &cubature)?,
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
