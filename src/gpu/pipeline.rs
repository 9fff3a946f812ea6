//! Entry points compiled for a device: what depends on a kernel's text and on no buffer.

use super::kernel::{Bindings, Kernel};
use super::listener::Listener;
use super::module::Module;
use crate::{GpuError, Result};
use naga::{AddressSpace, GlobalVariable, StorageAccess, TypeInner};
use std::future::Future;

/// A module that the device has taken.
#[derive(Debug)]
pub struct Shader {
    device: wgpu::Device,
    module: Module,
    raw: wgpu::ShaderModule,
}

/// An entry point, ready for buffers to be bound to it.
#[derive(Clone, Debug)]
pub struct Pipeline {
    pub(super) device: wgpu::Device,
    pub(super) label: String,
    pub(super) raw: wgpu::ComputePipeline,
    pub(super) layout: wgpu::BindGroupLayout,
    /// The variables that it reads and writes, with the numbers of their bindings.
    pub(super) variables: Vec<(String, u32)>,
    /// Whether a dispatch says where one of them lies.
    pub(super) dynamic: bool,
}

impl Module {
    /// Hands the text to `device`. The future says whether the driver took it; natively it is ready.
    pub fn shader(
        self,
        device: &wgpu::Device,
    ) -> (Shader, impl Future<Output = Result<()>> + use<>) {
        let listener = Listener::new(device);
        let raw = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(&self.name),
            source: wgpu::ShaderSource::Wgsl(self.source.as_str().into()),
        });
        let checked = refusal(self.name.clone(), listener);
        let device = device.clone();
        let module = self;
        (
            Shader {
                device,
                module,
                raw,
            },
            checked,
        )
    }
}

impl Shader {
    /// The module.
    pub fn module(&self) -> &Module {
        &self.module
    }

    /// Compiles entry point `entry`, of whose buffers those in `dynamic` are bound one item at a time. The future says
    /// whether the driver took it; natively it is ready.
    ///
    /// # Errors
    /// [`GpuError::Limit`] where the device offers fewer storage buffers, [`GpuError::Shader`] where there is no such
    /// entry point.
    pub fn pipeline(
        &self,
        entry: &str,
        dynamic: &[&str],
        cache: Option<&wgpu::PipelineCache>,
    ) -> Result<(Pipeline, impl Future<Output = Result<()>> + use<>)> {
        let (device, module) = (&self.device, &self.module);
        let label = format!("{}.{entry}", module.name);
        let index = (module.entry_points())
            .position(|name| name == entry)
            .ok_or_else(|| GpuError::Shader {
                kernel: label.clone(),
                message: "there is no such entry point".to_owned(),
            })?;
        let limit = u64::from(device.limits().max_storage_buffers_per_shader_stage);
        let needed = module.storage_buffers(entry).unwrap_or(0) as u64;
        if needed > limit {
            return Err(GpuError::Limit {
                what: format!("storage buffers of kernel {label}"),
                needed,
                limit,
                cure: "request the device with required_limits()",
            }
            .into());
        }
        let mut variables = Vec::new();
        let mut entries = Vec::new();
        for global in module.globals(index) {
            let name = global.name.clone().unwrap_or_default();
            let binding = global.binding.as_ref().map_or(0, |b| b.binding);
            entries.push(wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::COMPUTE,
                ty: binding_type(module, global, dynamic.contains(&name.as_str())),
                count: None,
            });
            variables.push((name, binding));
        }
        let listener = Listener::new(device);
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(&label),
            entries: &entries,
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(&label),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let raw = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(&label),
            layout: Some(&pipeline_layout),
            module: &self.raw,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions {
                // Every kernel writes its workgroup memory before it reads it.
                zero_initialize_workgroup_memory: false,
                ..Default::default()
            },
            cache,
        });
        #[cfg(test)]
        made::COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let checked = refusal(label.clone(), listener);
        let dynamic = variables.iter().any(|(v, _)| dynamic.contains(&v.as_str()));
        let device = device.clone();
        Ok((
            Pipeline {
                device,
                label,
                raw,
                layout,
                variables,
                dynamic,
            },
            checked,
        ))
    }
}

impl Pipeline {
    /// The pipeline with `bindings` bound by name.
    ///
    /// # Errors
    /// [`GpuError::MissingBuffer`] names a variable nothing was given for.
    pub fn bind(&self, bindings: &Bindings<'_>) -> Result<Kernel> {
        Kernel::new(self, bindings)
    }
}

fn binding_type(module: &Module, global: &GlobalVariable, dynamic: bool) -> wgpu::BindingType {
    if matches!(
        module.module.types[global.ty].inner,
        TypeInner::Image { .. }
    ) {
        return wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D3,
            multisampled: false,
        };
    }
    let ty = match global.space {
        AddressSpace::Storage { access } => wgpu::BufferBindingType::Storage {
            read_only: !access.contains(StorageAccess::STORE),
        },
        _ => wgpu::BufferBindingType::Uniform,
    };
    wgpu::BindingType::Buffer {
        ty,
        has_dynamic_offset: dynamic,
        min_binding_size: None,
    }
}

/// What the driver said of `kernel`, as an error.
fn refusal(kernel: String, listener: Listener) -> impl Future<Output = Result<()>> + use<> {
    let heard = listener.heard();
    async move {
        match heard.await {
            Some(message) => Err(GpuError::Shader { kernel, message }.into()),
            None => Ok(()),
        }
    }
}

/// Counts pipelines, so that tests see who makes them.
#[cfg(test)]
pub(crate) mod made {
    use std::sync::Mutex;
    use std::sync::atomic::AtomicUsize;

    /// Held by tests that make pipelines, which so are counted one test after the other.
    pub static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

    /// Pipelines that this process has made.
    pub static COUNT: AtomicUsize = AtomicUsize::new(0);
}
