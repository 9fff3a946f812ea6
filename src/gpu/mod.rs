//! Plumbing that knows no physics: device, kernel, buffers, readback.

pub(crate) mod buffer;
pub(crate) mod buffer_list;
mod device;
pub(crate) mod kernel;
pub(crate) mod layout;
pub(crate) mod readback;

pub(crate) use buffer::Buffer;
pub(crate) use buffer_list::Allocator;
pub use device::{
    AdapterChoice, AdapterDescription, AdapterKind, GpuDevice, adapters, required_features,
    required_limits,
};
pub(crate) use kernel::{Bindings, Kernel, Module};
pub(crate) use layout::{HostShareable, SharedValue, StructLayout};
pub(crate) use readback::Readback;
pub use readback::Waiting;

pub(crate) use buffer_list::buffers;
pub(crate) use layout::host_shareable;
