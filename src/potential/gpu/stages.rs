//! All stages together.

use super::buffers::Buffers;
use super::dispatch::Batch;
use super::sources::Sources;
use super::stage::{Stage, StagePipelines};
use super::stage_list::with_stages;
use crate::gpu::Module;
use crate::{GpuError, Result};

/// One way to dispatch one of the stages.
pub(super) type Dispatch = Box<dyn Fn(&Stages, &mut wgpu::ComputePass<'_>, Batch) + Send + Sync>;

macro_rules! stages {
    ($($name:ident: $stage:ident,)*) => {
        /// Every stage, ready to be dispatched.
        #[derive(Debug)]
        pub(super) struct Stages {
            $(pub $name: super::$name::$stage,)*
        }

        impl Stages {
            /// Binds `buffers` to the pipelines of all stages.
            pub fn new(pipelines: &[StagePipelines], buffers: &Buffers) -> Result<Self> {
                Ok(Self { $($name: Stage::new(find(pipelines, stringify!($name))?, buffers)?,)* })
            }

            /// What is timed of every stage, under its name.
            pub fn timed() -> Vec<(&'static str, Dispatch)> {
                let mut out: Vec<(&'static str, Dispatch)> = Vec::new();
                $(for (name, run) in <super::$name::$stage as Stage>::timed(stringify!($name)) {
                    out.push((name, Box::new(move |stages, pass, batch| run(&stages.$name, pass, batch))));
                })*
                out
            }
        }

        /// Every stage's name, and the files that its own builds on.
        pub(super) const INCLUDES: &[(&str, &[&str])] =
            &[$((stringify!($name), <super::$name::$stage as Stage>::INCLUDES)),*];
    };
}
with_stages!(stages);

fn find<'a>(pipelines: &'a [StagePipelines], name: &str) -> Result<&'a StagePipelines> {
    let found = pipelines.iter().find(|p| p.name == name);
    Ok(found.ok_or_else(|| GpuError::Shader {
        kernel: name.to_owned(),
        message: "is not compiled".to_owned(),
    })?)
}

/// Every kernel, parsed and validated; needs no device.
///
/// # Errors
/// [`GpuError::Shader`] of the first that does not compile.
pub fn modules(sources: &Sources) -> Result<Vec<Module>> {
    (INCLUDES.iter())
        .map(|(name, includes)| sources.module(name, includes))
        .collect()
}
