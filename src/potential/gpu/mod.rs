//! The potential on the GPU, in the order in which the data flows; a file imports only files named before it.
//!
//! - **What the kernels see.** [`shared`] has the structs that both sides read, `pack` makes them of the model's f64
//!   numbers, `tables` holds those of an avatar that never change.
//! - **What the device holds.** `stage_list` names the stages, `sources` composes their texts, `options` is what a host
//!   chooses, `dispatch` is a batch of states and its chunks, `sizes` says how many of what there are, `grids` and
//!   `buffers` are the memory.
//! - **The stages.** `stage` is what they have in common; then one file a kernel; `stages` is all of them, and `kernels`
//!   their pipelines, which potentials of one material law share.
//! - **A step.** `recorder` is what is made once for a batch of avatars, `upload` sends states, `begin_step`, `geometric`,
//!   `evaluate`, `end_step`, `energy_differences`, `pose_skin` and `contact_forces` record the stages into a submission and
//!   unpack what it brings back; `potential` submits and awaits, `profile` times the stages one by one.

// What the kernels see.
mod pack;
pub mod shared;
mod tables;

// What the device holds.
mod buffers;
mod dispatch;
mod grids;
mod options;
mod sizes;
mod sources;
mod stage_list;

// The stages, one line each here and in `stage_list`.
mod compact;
mod contact;
mod displacement;
mod elasticity;
mod energy;
mod friction;
mod gradient;
mod hessian;
mod inertial_target;
mod normals;
mod point_hessian;
mod pose_blend;
mod select;
mod skin;
mod stage;
mod stages;

// Their pipelines.
mod kernels;

// A step.
mod begin_step;
mod contact_forces;
mod end_step;
mod energy_differences;
mod evaluate;
mod geometric;
mod pose_skin;
mod potential;
mod profile;
mod recorder;
mod upload;

pub use kernels::GpuKernels;
pub use options::GpuOptions;
pub use potential::GpuPotential;
pub use recorder::Recorder;
pub use sources::Sources;
pub use stages::modules;
