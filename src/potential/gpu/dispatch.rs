//! How kernels are dispatched over a batch of states.

use crate::gpu::Kernel;

/// Threads of a workgroup in kernels that take one thread an item.
const WORKGROUP: u32 = 64;

/// Bytes between two chunks' uniforms: WebGPU's `min_uniform_buffer_offset_alignment`.
pub(super) const CHUNK_STRIDE: u64 = 256;

/// Workgroups of a kernel that takes one thread for each of `items`.
pub(super) fn workgroups(items: usize) -> u32 {
    (items as u32).div_ceil(WORKGROUP)
}

/// States that a dispatch takes: which chunk of the batch, and how many.
#[derive(Clone, Copy, Debug)]
pub(super) struct Batch {
    pub chunk: u32,
    pub states: u32,
}

impl Batch {
    /// The first `states` states, which need no scratch memory.
    pub fn whole(states: usize) -> Self {
        Self {
            chunk: 0,
            states: states as u32,
        }
    }

    pub fn dispatch(self, kernel: &Kernel, pass: &mut wgpu::ComputePass<'_>, workgroups: u32) {
        let offset = self.chunk * CHUNK_STRIDE as u32;
        kernel.dispatch(pass, [workgroups, self.states, 1], offset);
    }
}
