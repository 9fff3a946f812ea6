//! All stages together.

use super::buffers::Buffers;
use super::dispatch::Batch;
use super::sources::Sources;
use super::stage::Stage;
use super::stage_list::with_stages;
use crate::Result;
use crate::gpu::Module;

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
            pub fn new(device: &wgpu::Device, sources: &Sources, buffers: &Buffers) -> Result<Self> {
                Ok(Self {
                    $($name: {
                        let includes = <super::$name::$stage as Stage>::INCLUDES;
                        Stage::new(device, &sources.module(stringify!($name), includes)?, buffers)?
                    },)*
                })
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

        /// Every kernel, parsed and validated; needs no device.
        ///
        /// # Errors
        /// [`crate::GpuError::Shader`] of the first that does not compile.
        pub fn modules(sources: &Sources) -> Result<Vec<Module>> {
            Ok(vec![
                $(sources.module(stringify!($name), <super::$name::$stage as Stage>::INCLUDES)?,)*
            ])
        }
    };
}
with_stages!(stages);
