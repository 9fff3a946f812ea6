//! Compute kernels in WGSL: parsed, validated, and bound by the names their text uses.

use crate::{GpuError, Result};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{AddressSpace, GlobalVariable, StorageAccess};

/// A parsed and validated WGSL module.
#[derive(Debug)]
pub struct Module {
    name: String,
    source: String,
    module: naga::Module,
    info: ModuleInfo,
}

impl Module {
    /// Parses and validates `source`; needs no device.
    ///
    /// # Errors
    /// [`GpuError::Shader`] with the compiler's message and the line.
    pub fn parse(name: &str, source: String) -> Result<Self> {
        let fail = |message: String| GpuError::Shader {
            kernel: name.to_owned(),
            message,
        };
        let module = naga::front::wgsl::parse_str(&source)
            .map_err(|e| fail(e.emit_to_string_with_path(&source, name)))?;
        let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&module)
            .map_err(|e| fail(e.emit_to_string_with_path(&source, name)))?;
        Ok(Self {
            name: name.to_owned(),
            source,
            module,
            info,
        })
    }

    /// What the compiler's front made of it.
    pub fn parsed(&self) -> &naga::Module {
        &self.module
    }

    /// Names of the entry points.
    pub fn entry_points(&self) -> impl Iterator<Item = &str> {
        self.module.entry_points.iter().map(|e| e.name.as_str())
    }

    /// Size and field offsets of the struct `name` as the kernel sees it.
    pub fn struct_layout(&self, name: &str) -> Option<(usize, Vec<(String, usize)>)> {
        self.module
            .types
            .iter()
            .find_map(|(_, ty)| match &ty.inner {
                naga::TypeInner::Struct { members, span } if ty.name.as_deref() == Some(name) => {
                    let fields = members
                        .iter()
                        .map(|m| (m.name.clone().unwrap_or_default(), m.offset as usize));
                    Some((*span as usize, fields.collect()))
                }
                _ => None,
            })
    }

    /// Names of the structs the module declares.
    pub fn structs(&self) -> impl Iterator<Item = &str> {
        self.module.types.iter().filter_map(|(_, ty)| {
            matches!(ty.inner, naga::TypeInner::Struct { .. }).then_some(ty.name.as_deref()?)
        })
    }

    /// The buffers that entry point `entry` uses.
    fn globals(&self, entry: usize) -> impl Iterator<Item = &GlobalVariable> {
        let usage = self.info.get_entry_point(entry);
        self.module
            .global_variables
            .iter()
            .filter(move |(handle, global)| global.binding.is_some() && !usage[*handle].is_empty())
            .map(|(_, global)| global)
    }

    /// Number of storage buffers that entry point `entry` uses.
    pub fn storage_buffers(&self, entry: &str) -> Option<usize> {
        let index = self
            .module
            .entry_points
            .iter()
            .position(|e| e.name == entry)?;
        Some(
            self.globals(index)
                .filter(|g| matches!(g.space, AddressSpace::Storage { .. }))
                .count(),
        )
    }

    /// The pipeline of entry point `entry`, with `bindings` bound by name.
    ///
    /// # Errors
    /// [`GpuError::MissingBuffer`] names a variable nothing was given for, [`GpuError::Limit`] a device
    /// that offers fewer storage buffers, [`GpuError::Shader`] a refusal of the driver.
    pub fn kernel(
        &self,
        device: &wgpu::Device,
        entry: &str,
        bindings: &Bindings<'_>,
    ) -> Result<Kernel> {
        let label = format!("{}.{entry}", self.name);
        let shader_error = |message: String| GpuError::Shader {
            kernel: label.clone(),
            message,
        };
        let index = (self.module.entry_points.iter())
            .position(|e| e.name == entry)
            .ok_or_else(|| shader_error("there is no such entry point".to_owned()))?;
        let limit = u64::from(device.limits().max_storage_buffers_per_shader_stage);
        let needed = self.storage_buffers(entry).unwrap_or(0) as u64;
        if needed > limit {
            return Err(GpuError::Limit {
                what: format!("storage buffers of kernel {label}"),
                needed,
                limit,
                cure: "request the device with required_limits()",
            }
            .into());
        }

        let mut layout = Vec::new();
        let mut entries = Vec::new();
        let mut dynamic = false;
        for global in self.globals(index) {
            let name = global.name.as_deref().unwrap_or_default();
            let slot = global.binding.as_ref().map_or(0, |b| b.binding);
            let bound = bindings.find(name).ok_or_else(|| GpuError::MissingBuffer {
                kernel: label.clone(),
                binding: name.to_owned(),
            })?;
            let (ty, resource) = match bound.resource {
                Resource::Buffer { buffer, stride } => {
                    let ty = match global.space {
                        AddressSpace::Storage { access } => wgpu::BufferBindingType::Storage {
                            read_only: !access.contains(StorageAccess::STORE),
                        },
                        _ => wgpu::BufferBindingType::Uniform,
                    };
                    dynamic |= stride.is_some();
                    let ty = wgpu::BindingType::Buffer {
                        ty,
                        has_dynamic_offset: stride.is_some(),
                        min_binding_size: None,
                    };
                    let size = stride.and_then(wgpu::BufferSize::new);
                    let binding = wgpu::BufferBinding {
                        buffer,
                        offset: 0,
                        size,
                    };
                    (ty, wgpu::BindingResource::Buffer(binding))
                }
                Resource::Texture(view) => {
                    let ty = wgpu::BindingType::Texture {
                        sample_type: wgpu::TextureSampleType::Float { filterable: false },
                        view_dimension: wgpu::TextureViewDimension::D3,
                        multisampled: false,
                    };
                    (ty, wgpu::BindingResource::TextureView(view))
                }
            };
            layout.push(wgpu::BindGroupLayoutEntry {
                binding: slot,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty,
                count: None,
            });
            entries.push(wgpu::BindGroupEntry {
                binding: slot,
                resource,
            });
        }

        let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
        let shader = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(&label),
            source: wgpu::ShaderSource::Wgsl(self.source.as_str().into()),
        });
        let bind_group_layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(&label),
            entries: &layout,
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(&label),
            bind_group_layouts: &[Some(&bind_group_layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(&label),
            layout: Some(&pipeline_layout),
            module: &shader,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions {
                // Every kernel writes its workgroup memory before it reads it.
                zero_initialize_workgroup_memory: false,
                ..Default::default()
            },
            cache: None,
        });
        let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&label),
            layout: &bind_group_layout,
            entries: &entries,
        });
        // In a browser the error arrives later, as an uncaptured one.
        #[cfg(not(target_arch = "wasm32"))]
        if let Some(error) = pollster::block_on(scope.pop()) {
            return Err(shader_error(error.to_string()).into());
        }
        #[cfg(target_arch = "wasm32")]
        drop(scope);
        Ok(Kernel {
            pipeline,
            bind_group,
            dynamic,
        })
    }
}

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
