//! What a stage is to those that know nothing of it but its name.

use super::buffers::Buffers;
use super::dispatch::Batch;
use crate::gpu::{Bindings, Kernel, Pipeline};
use crate::{GpuError, Result};

/// One way to dispatch a stage.
pub(super) type Run<S> = fn(&S, &mut wgpu::ComputePass<'_>, Batch);

/// The compiled entry points of a stage.
#[derive(Debug)]
pub(super) struct StagePipelines {
    pub name: &'static str,
    /// By entry point.
    pub entries: Vec<(String, Pipeline)>,
}

impl StagePipelines {
    /// Entry point `entry` with `bindings` bound by name.
    ///
    /// # Errors
    /// [`GpuError::Shader`] where there is no such entry point, [`GpuError::MissingBuffer`] names a variable nothing was
    /// given for.
    pub fn kernel(&self, entry: &str, bindings: &Bindings<'_>) -> Result<Kernel> {
        let (_, pipeline) = (self.entries.iter())
            .find(|(name, _)| name == entry)
            .ok_or_else(|| GpuError::Shader {
                kernel: self.name.to_owned(),
                message: format!("there is no entry point {entry}"),
            })?;
        pipeline.bind(bindings)
    }
}

/// The host side of a kernel file: its pipelines, and how they are dispatched.
pub(super) trait Stage: Sized + 'static {
    /// Files under `kernels/` that the stage's own builds on, in order.
    const INCLUDES: &'static [&'static str];

    /// The stage's `pipelines`, with `buffers` bound.
    fn new(pipelines: &StagePipelines, buffers: &Buffers) -> Result<Self>;

    /// As an evaluation runs it.
    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch);

    /// What is timed of it, under which names.
    fn timed(name: &'static str) -> Vec<(&'static str, Run<Self>)> {
        vec![(name, Self::dispatch)]
    }
}
