//! What a stage is to those that know nothing of it but its name.

use super::buffers::Buffers;
use super::dispatch::Batch;
use crate::Result;
use crate::gpu::Module;

/// One way to dispatch a stage.
pub(super) type Run<S> = fn(&S, &mut wgpu::ComputePass<'_>, Batch);

/// The host side of a kernel file: its pipelines, and how they are dispatched.
pub(super) trait Stage: Sized + 'static {
    /// Files under `kernels/` that the stage's own builds on, in order.
    const INCLUDES: &'static [&'static str];

    /// The pipelines of `module`, with their buffers bound.
    fn new(device: &wgpu::Device, module: &Module, buffers: &Buffers) -> Result<Self>;

    /// As an evaluation runs it.
    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch);

    /// What is timed of it, under which names.
    fn timed(name: &'static str) -> Vec<(&'static str, Run<Self>)> {
        vec![(name, Self::dispatch)]
    }
}
