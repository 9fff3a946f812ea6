//! One typed wrapper a kernel, and the evaluation of the potential made of them.

mod begin_step;
mod buffers;
mod compact;
mod contact;
mod displacement;
mod elasticity;
mod energy;
mod energy_differences;
mod evaluate;
mod friction;
mod geometric;
mod gradient;
mod grids;
mod hessian;
mod normals;
mod point_hessian;
mod pose_blend;
mod pose_skin;
mod potential;
mod profile;
pub mod shared;
mod skin;
mod sources;
mod tables;
mod upload;

pub use potential::{GpuOptions, GpuPotential};
pub use sources::Sources;

use crate::Result;
use crate::gpu::{Kernel, Module};

/// Threads of a workgroup in kernels that take one thread an item.
const WORKGROUP: u32 = 64;

/// States that a dispatch takes: which chunk of the batch, and how many.
#[derive(Clone, Copy, Debug)]
struct Batch {
    chunk: u32,
    states: u32,
}

impl Batch {
    fn dispatch(self, kernel: &Kernel, pass: &mut wgpu::ComputePass<'_>, workgroups: u32) {
        let offset = self.chunk * buffers::CHUNK_STRIDE as u32;
        kernel.dispatch(pass, [workgroups, self.states, 1], offset);
    }
}

/// What each kernel is composed of.
const KERNELS: &[(&str, &[&str])] = &[
    ("pose_blend", pose_blend::INCLUDES),
    ("displacement", displacement::INCLUDES),
    ("elasticity", elasticity::INCLUDES),
    ("contact", contact::INCLUDES),
    ("friction", friction::INCLUDES),
    ("compact", compact::INCLUDES),
    ("gradient", gradient::INCLUDES),
    ("point_hessian", point_hessian::INCLUDES),
    ("hessian", hessian::INCLUDES),
    ("energy", energy::INCLUDES),
    ("skin", skin::INCLUDES),
    ("normals", normals::INCLUDES),
];

/// Every kernel, parsed and validated; needs no device.
///
/// # Errors
/// [`crate::GpuError::Shader`] of the first that does not compile.
pub fn modules(sources: &Sources) -> Result<Vec<Module>> {
    KERNELS
        .iter()
        .map(|(name, includes)| sources.module(name, includes))
        .collect()
}
