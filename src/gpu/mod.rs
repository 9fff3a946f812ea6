//! Plumbing that knows no physics: device, kernel, buffers, readback.

mod buffer;
mod buffer_list;
mod device;
mod kernel;
mod layout;
mod readback;

pub use buffer::Buffer;
pub use buffer_list::Allocator;
pub use device::{
    AdapterChoice, AdapterDescription, AdapterKind, GpuDevice, adapters, required_features,
    required_limits,
};
pub use kernel::{Bindings, Kernel, Module};
pub use layout::{HostShareable, SharedValue, StructLayout};
pub use readback::{Readback, Waiting};

pub(crate) use buffer_list::buffers;
pub(crate) use layout::host_shareable;
