//! What kernels are bound to, by the names that their texts use, and how they are dispatched.

use super::pipeline::Pipeline;
use crate::{GpuError, Result};

#[derive(Clone, Copy, Debug)]
struct Bound<'a> {
    name: &'a str,
    resource: Resource<'a>,
}

#[derive(Clone, Copy, Debug)]
enum Resource<'a> {
    /// A whole buffer, or one item of `stride` bytes of it.
    Buffer {
        buffer: &'a wgpu::Buffer,
        stride: Option<u64>,
    },
    /// A 3D texture of single floats.
    Texture(&'a wgpu::TextureView),
}

/// Buffers and textures under the names that kernels call them by; a later one hides an earlier one.
#[derive(Clone, Debug, Default)]
pub struct Bindings<'a>(Vec<Bound<'a>>);

impl<'a> Bindings<'a> {
    /// The same with `buffer` as `name`.
    #[must_use]
    pub fn with(self, name: &'a str, buffer: &'a wgpu::Buffer) -> Self {
        let stride = None;
        self.push(name, Resource::Buffer { buffer, stride })
    }

    /// The same with a 3D texture of single floats as `name`; kernels load from it, nothing filters.
    #[must_use]
    pub fn with_texture(self, name: &'a str, view: &'a wgpu::TextureView) -> Self {
        self.push(name, Resource::Texture(view))
    }

    fn push(mut self, name: &'a str, resource: Resource<'a>) -> Self {
        self.0.push(Bound { name, resource });
        self
    }

    /// The same with one item of `stride` bytes of `buffer` as `name`; each dispatch says where it lies.
    #[must_use]
    pub fn with_dynamic(self, name: &'a str, buffer: &'a wgpu::Buffer, stride: u64) -> Self {
        let stride = Some(stride);
        self.push(name, Resource::Buffer { buffer, stride })
    }

    fn find(&self, name: &str) -> Option<Bound<'a>> {
        self.0.iter().rev().find(|b| b.name == name).copied()
    }
}

/// A pipeline with its buffers bound.
#[derive(Clone, Debug)]
pub struct Kernel {
    pipeline: wgpu::ComputePipeline,
    bind_group: wgpu::BindGroup,
    dynamic: bool,
}

impl Kernel {
    /// `pipeline` with `bindings` bound by name.
    ///
    /// # Errors
    /// [`GpuError::MissingBuffer`] names a variable nothing was given for.
    pub(super) fn new(pipeline: &Pipeline, bindings: &Bindings<'_>) -> Result<Self> {
        let mut entries = Vec::new();
        for (name, binding) in &pipeline.variables {
            let bound = bindings.find(name).ok_or_else(|| GpuError::MissingBuffer {
                kernel: pipeline.label.clone(),
                binding: name.clone(),
            })?;
            let resource = match bound.resource {
                Resource::Buffer { buffer, stride } => {
                    wgpu::BindingResource::Buffer(wgpu::BufferBinding {
                        buffer,
                        offset: 0,
                        size: stride.and_then(wgpu::BufferSize::new),
                    })
                }
                Resource::Texture(view) => wgpu::BindingResource::TextureView(view),
            };
            entries.push(wgpu::BindGroupEntry {
                binding: *binding,
                resource,
            });
        }
        let bind_group = (pipeline.device).create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&pipeline.label),
            layout: &pipeline.layout,
            entries: &entries,
        });
        Ok(Self {
            pipeline: pipeline.raw.clone(),
            bind_group,
            dynamic: pipeline.dynamic,
        })
    }

    /// Records a run of `workgroups`; `offset` is the byte offset of the dynamic binding, if there is one.
    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, workgroups: [u32; 3], offset: u32) {
        if workgroups.contains(&0) {
            return;
        }
        pass.set_pipeline(&self.pipeline);
        let offsets = [offset];
        pass.set_bind_group(0, &self.bind_group, &offsets[..usize::from(self.dynamic)]);
        let [x, y, z] = workgroups;
        pass.dispatch_workgroups(x, y, z);
    }
}
