//! The device that draws, and steps where the world is on it.

use supple::wgpu;
use supple::{Error, GpuError, Result};

/// A device and its queue.
#[derive(Clone, Debug)]
pub struct Gpu {
    /// What it is.
    pub adapter: wgpu::Adapter,
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
}

impl Gpu {
    /// A device that can draw on `surface`, if one is given, and has what a world's kernels need.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] and [`GpuError::NoDevice`], each with what to do about it.
    pub async fn open(
        instance: &wgpu::Instance,
        surface: Option<&wgpu::Surface<'_>>,
    ) -> Result<Self> {
        let adapter = instance
            .request_adapter(&wgpu::RequestAdapterOptions {
                power_preference: wgpu::PowerPreference::HighPerformance,
                compatible_surface: surface,
                ..Default::default()
            })
            .await;
        let adapter = adapter.map_err(|e| {
            let cure = "install a driver of Vulkan; Mesa's lavapipe will do (mesa-vulkan-drivers)";
            Error::from(GpuError::NoAdapter(format!("{e}; {cure}")))
        })?;
        let device = adapter
            .request_device(&wgpu::DeviceDescriptor {
                label: Some("supple view"),
                required_features: supple::gpu::required_features(),
                required_limits: supple::gpu::required_limits(),
                ..Default::default()
            })
            .await;
        let (device, queue) = device.map_err(|e| GpuError::NoDevice(e.to_string()))?;
        Ok(Self {
            adapter,
            device,
            queue,
        })
    }

    /// A device that draws on no window.
    ///
    /// # Errors
    /// As [`Gpu::open`].
    pub async fn open_without_window() -> Result<Self> {
        let descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        Self::open(&wgpu::Instance::new(descriptor), None).await
    }

    /// A buffer of `size` bytes.
    pub(crate) fn buffer(&self, label: &str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            // A binding of nothing is refused.
            size: size.max(32),
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// A buffer with `contents`.
    pub(crate) fn filled<T: bytemuck::Pod>(
        &self,
        label: &str,
        contents: &[T],
        usage: wgpu::BufferUsages,
    ) -> wgpu::Buffer {
        let bytes: &[u8] = bytemuck::cast_slice(contents);
        let buffer = self.buffer(label, bytes.len() as u64, usage);
        self.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    /// `resources` as a bind group of `layout`, in order.
    pub(crate) fn bind(
        &self,
        layout: &wgpu::BindGroupLayout,
        resources: &[wgpu::BindingResource<'_>],
    ) -> wgpu::BindGroup {
        let entries = (0..).zip(resources);
        let entries: Vec<_> = entries
            .map(|(binding, resource)| wgpu::BindGroupEntry {
                binding,
                resource: resource.clone(),
            })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout,
            entries: &entries,
        })
    }
}
