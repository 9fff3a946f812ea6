//! One list of buffers: a line of it is the field, the label, the creation and the binding of a buffer.

use super::Buffer;
use crate::Result;
use bytemuck::Pod;
use wgpu::BufferUsages;

/// Creates buffers in the few ways that this library uses them.
#[derive(Clone, Copy, Debug)]
pub struct Allocator<'a> {
    /// Where they live.
    pub device: &'a wgpu::Device,
    /// Where their first contents go through.
    pub queue: &'a wgpu::Queue,
}

impl Allocator<'_> {
    /// Room for `len` items, all bytes zero, that may be read back.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn zeroed<T: Pod>(&self, label: &str, len: usize) -> Result<Buffer<T>> {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        Buffer::new(self.device, label, len, usage)
    }

    /// [`Allocator::zeroed`] that is drawn from as well.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn vertices<T: Pod>(&self, label: &str, len: usize) -> Result<Buffer<T>> {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::VERTEX;
        Buffer::new(self.device, label, len, usage)
    }

    /// The constant `items`.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn holding<T: Pod>(&self, label: &str, items: &[T]) -> Result<Buffer<T>> {
        Buffer::holding(self.device, self.queue, label, items, BufferUsages::STORAGE)
    }

    /// The constant `items` as uniforms.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn uniform<T: Pod>(&self, label: &str, items: &[T]) -> Result<Buffer<T>> {
        Buffer::holding(self.device, self.queue, label, items, BufferUsages::UNIFORM)
    }
}

/// Tells what an [`Allocator`] would create: the bytes that a kernel would bind.
#[derive(Clone, Copy, Debug)]
pub struct Measure;

impl Measure {
    /// Bytes of [`Allocator::zeroed`].
    pub fn zeroed<T: Pod>(self, len: usize) -> u64 {
        len as u64 * size_of::<T>() as u64
    }

    /// Bytes of [`Allocator::vertices`].
    pub fn vertices<T: Pod>(self, len: usize) -> u64 {
        self.zeroed::<T>(len)
    }

    /// Bytes of [`Allocator::holding`].
    pub fn holding<T: Pod>(self, items: &[T]) -> u64 {
        self.zeroed::<T>(items.len())
    }

    /// Nothing: of uniforms a kernel binds an item.
    pub fn uniform<T: Pod>(self, _: &[T]) -> u64 {
        0
    }
}

/// Declares a struct of buffers, one line a buffer: the name that kernels bind it by, its items, and how an
/// [`Allocator`] creates it from the struct's parameters.
///
/// ```text
/// buffers! {
///     /// What moves.
///     pub(super) struct Moving(bones: usize) {
///         /// Of every bone.
///         frames: Frame = zeroed(bones),
///     }
/// }
/// let moving = Moving::new(allocator, 16)?;
/// moving.frames.write(queue, 0, &frames);
/// let bindings = moving.bound(Bindings::default());  // `frames` in WGSL
/// ```
macro_rules! buffers {
    (
        $(#[$doc:meta])*
        $visibility:vis struct $name:ident($($parameter:ident: $type:ty),*) {
            $($(#[$field_doc:meta])* $field:ident: $item:ty = $contents:ident($from:expr),)*
        }
    ) => {
        $(#[$doc])*
        #[derive(Debug)]
        $visibility struct $name { $($(#[$field_doc])* pub $field: $crate::gpu::Buffer<$item>,)* }

        impl $name {
            /// All of them.
            ///
            /// # Errors
            /// As [`crate::gpu::Buffer::new`].
            pub fn new(
                allocator: $crate::gpu::Allocator<'_>,
                $($parameter: $type),*
            ) -> $crate::Result<Self> {
                Ok(Self { $($field: allocator.$contents(stringify!($field), $from)?,)* })
            }

            /// Bytes of the largest that kernels bind whole, and its name; creates nothing.
            pub fn largest($($parameter: $type),*) -> (u64, &'static str) {
                let all = [
                    $(($crate::gpu::Measure.$contents::<$item>($from), stringify!($field)),)*
                ];
                all.into_iter().max().unwrap_or_default()
            }

            /// The buffer that kernels bind as `name`.
            pub fn find(&self, name: &str) -> Option<&wgpu::Buffer> {
                $(if name == stringify!($field) {
                    return Some(self.$field.raw());
                })*
                None
            }

            /// `bindings` with all of them.
            pub fn bound<'a>(&'a self, bindings: $crate::gpu::Bindings<'a>) -> $crate::gpu::Bindings<'a> {
                bindings $(.with(stringify!($field), self.$field.raw()))*
            }
        }
    };
}
pub(crate) use buffers;
