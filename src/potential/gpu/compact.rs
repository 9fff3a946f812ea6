//! Active contacts in fixed order, and the blocks of q that they move.

use super::buffers::Buffers;
use super::dispatch::{Batch, workgroups};
use super::stage::{Stage, StagePipelines};
use crate::Result;
use crate::gpu::Kernel;

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

impl Stage for Compact {
    const INCLUDES: &'static [&'static str] = &[
        "shared/batch.wgsl",
        "shared/kinematics.wgsl",
        "shared/point_motion.wgsl",
        "shared/contact.wgsl",
        "shared/contact_stiffness.wgsl",
        "shared/friction.wgsl",
        "shared/exclusive_sum.wgsl",
    ];

    fn new(pipelines: &StagePipelines, buffers: &Buffers) -> Result<Self> {
        let kernel = |entry| pipelines.kernel(entry, &buffers.over_skin());
        Ok(Self {
            compact: kernel("compact")?,
            friction_rows: kernel("friction_rows")?,
            contact_rows: kernel("contact_rows_of")?,
            block_contacts: kernel("block_contacts_of")?,
            lagged_groups: workgroups(buffers.sizes.contacts),
            row_groups: workgroups(buffers.sizes.rows),
            blocks: buffers.sizes.blocks as u32,
        })
    }

    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.compact, pass, 1);
        batch.dispatch(&self.friction_rows, pass, self.lagged_groups);
        batch.dispatch(&self.contact_rows, pass, self.row_groups);
        batch.dispatch(&self.block_contacts, pass, self.blocks);
    }
}
