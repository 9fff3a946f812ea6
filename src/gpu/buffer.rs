//! Typed buffers.

use crate::{GpuError, Result};
use bytemuck::Pod;
use std::marker::PhantomData;
use wgpu::BufferUsages;

/// A buffer of `T` on the device.
#[derive(Clone, Debug)]
pub struct Buffer<T> {
    raw: wgpu::Buffer,
    len: usize,
    marker: PhantomData<T>,
}

impl<T: Pod> Buffer<T> {
    /// Room for `len` items, all bytes zero. An empty one holds one item, since nothing empty binds.
    ///
    /// # Errors
    /// [`GpuError::Limit`] where it would exceed what the device binds at once.
    pub fn new(
        device: &wgpu::Device,
        label: &str,
        len: usize,
        usage: BufferUsages,
    ) -> Result<Self> {
        let bytes = (len.max(1) * size_of::<T>()).next_multiple_of(4) as u64;
        let limits = device.limits();
        let limit = limits
            .max_buffer_size
            .min(limits.max_storage_buffer_binding_size);
        if bytes > limit {
            return Err(GpuError::Limit {
                what: format!("bytes in buffer `{label}`"),
                needed: bytes,
                limit,
                cure: "use fewer instances or a smaller avatar",
            }
            .into());
        }
        let raw = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes,
            usage: usage | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Ok(Self {
            raw,
            len,
            marker: PhantomData,
        })
    }

    /// A buffer holding `items`.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub fn holding(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        label: &str,
        items: &[T],
        usage: BufferUsages,
    ) -> Result<Self> {
        let buffer = Self::new(device, label, items.len(), usage)?;
        buffer.write(queue, 0, items);
        Ok(buffer)
    }

    /// Overwrites items from `first` on, before the next submission runs.
    ///
    /// # Panics
    /// Where they do not fit; the lengths are this library's own.
    pub fn write(&self, queue: &wgpu::Queue, first: usize, items: &[T]) {
        assert!(first + items.len() <= self.len, "write past the buffer");
        if !items.is_empty() {
            let offset = (first * size_of::<T>()) as u64;
            queue.write_buffer(&self.raw, offset, bytemuck::cast_slice(items));
        }
    }

    /// wgpu's handle.
    pub fn raw(&self) -> &wgpu::Buffer {
        &self.raw
    }

    /// Number of items.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether it holds no item.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }
}
