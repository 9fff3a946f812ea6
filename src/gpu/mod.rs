//! Plumbing that knows no physics: device, kernels, buffers, submissions and their readback.

pub(crate) mod buffer;
pub(crate) mod buffer_list;
mod device;
pub(crate) mod kernel;
pub(crate) mod layout;
mod listener;
pub(crate) mod module;
pub(crate) mod pipeline;
pub(crate) mod readback;
pub(crate) mod submission;

pub(crate) use buffer::Buffer;
pub(crate) use buffer_list::{Allocator, Measure};
pub use device::{
    AdapterChoice, AdapterDescription, AdapterKind, GpuDevice, adapters, required_features,
    required_limits,
};
pub(crate) use kernel::{Bindings, Kernel};
pub(crate) use layout::{HostShareable, SharedValue, StructLayout};
pub(crate) use listener::Listener;
pub(crate) use module::Module;
pub(crate) use pipeline::{Pipeline, Shader};
pub use readback::Waiting;
pub(crate) use readback::{Bytes, Patience};
pub(crate) use submission::Submission;

pub(crate) use buffer_list::buffers;
pub(crate) use layout::host_shareable;
