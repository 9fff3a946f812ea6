//! Active contacts in fixed order, and the blocks of q that they move.

use super::buffers::{Buffers, row_room};
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
    "compact.wgsl",
];

/// The rows of the active contacts, each in the reduced space, and each block's rows.
#[derive(Debug)]
pub(super) struct Compact {
    compact: Kernel,
    friction_rows: Kernel,
    contact_rows: Kernel,
    block_contacts: Kernel,
    lagged_groups: u32,
    row_groups: u32,
    blocks: u32,
}

impl Compact {
    pub fn new(
        device: &wgpu::Device,
        sources: &Sources,
        buffers: &Buffers,
        contacts: usize,
        blocks: usize,
    ) -> Result<Self> {
        let module = sources.module("compact", INCLUDES)?;
        let kernel = |entry| module.kernel(device, entry, &buffers.over_skin());
        Ok(Self {
            compact: kernel("compact")?,
            friction_rows: kernel("friction_rows")?,
            contact_rows: kernel("contact_rows_of")?,
            block_contacts: kernel("block_contacts_of")?,
            lagged_groups: (contacts as u32).div_ceil(WORKGROUP),
            row_groups: (row_room(contacts) as u32).div_ceil(WORKGROUP),
            blocks: blocks as u32,
        })
    }

    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.compact, pass, 1);
        batch.dispatch(&self.friction_rows, pass, self.lagged_groups);
        batch.dispatch(&self.contact_rows, pass, self.row_groups);
        batch.dispatch(&self.block_contacts, pass, self.blocks);
    }
}
