//! Adapters and devices, for users who have none of their own.

use crate::{GpuError, Result};

/// Optional WebGPU features the kernels cannot do without: none.
pub fn required_features() -> wgpu::Features {
    wgpu::Features::empty()
}

/// Limits the kernels need: WebGPU's defaults, which include 8 storage buffers a stage, 128 MiB a
/// binding and 16 KiB of workgroup memory.
pub fn required_limits() -> wgpu::Limits {
    wgpu::Limits::default()
}

/// What executes an adapter's commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum AdapterKind {
    /// A graphics card, an integrated or a virtual one.
    Hardware,
    /// A CPU that plays a GPU (lavapipe, SwiftShader, WARP).
    Software,
    /// A device that does not say; OpenGL drivers often do not.
    Unknown,
}

/// What an adapter says of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterDescription {
    /// The device's name.
    pub name: String,
    /// The graphics interface: `vulkan`, `metal`, `dx12`, `gl` or `webgpu`.
    pub backend: String,
    /// What executes it.
    pub kind: AdapterKind,
    /// The driver and its version, where it says so.
    pub driver: String,
}

impl AdapterDescription {
    /// The description of wgpu's `info`.
    pub fn new(info: &wgpu::AdapterInfo) -> Self {
        use wgpu::DeviceType as T;
        Self {
            name: info.name.clone(),
            backend: info.backend.to_string(),
            kind: match info.device_type {
                T::DiscreteGpu | T::IntegratedGpu | T::VirtualGpu => AdapterKind::Hardware,
                T::Cpu => AdapterKind::Software,
                T::Other => AdapterKind::Unknown,
            },
            driver: format!("{} {}", info.driver, info.driver_info)
                .trim()
                .to_owned(),
        }
    }
}

/// Which adapters may be taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum AdapterChoice {
    /// A real GPU or nothing.
    #[default]
    Hardware,
    /// A real GPU, else a software one.
    HardwareElseSoftware,
    /// A software one, even beside a real GPU.
    Software,
}

impl AdapterChoice {
    /// Smaller is better; `None` is out of the question.
    fn preference(self, kind: AdapterKind) -> Option<u32> {
        use AdapterKind::{Hardware, Software, Unknown};
        match (self, kind) {
            (Self::Hardware | Self::HardwareElseSoftware, Hardware) => Some(0),
            (Self::Hardware | Self::HardwareElseSoftware, Unknown) => Some(1),
            (Self::HardwareElseSoftware, Software) => Some(2),
            (Self::Software, Software) => Some(0),
            _ => None,
        }
    }
}

/// A device made by this library, with its queue.
#[derive(Clone, Debug)]
pub struct GpuDevice {
    /// Where buffers and pipelines live.
    pub device: wgpu::Device,
    /// Where commands go.
    pub queue: wgpu::Queue,
    /// The adapter behind them.
    pub adapter: AdapterDescription,
}

/// Every adapter of this machine, in the order the system lists them.
pub async fn adapters() -> Vec<AdapterDescription> {
    enumerate()
        .await
        .iter()
        .map(|a| AdapterDescription::new(&a.get_info()))
        .collect()
}

async fn enumerate() -> Vec<wgpu::Adapter> {
    let instance =
        wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    instance.enumerate_adapters(wgpu::Backends::all()).await
}

impl GpuDevice {
    /// Opens the best adapter that `choice` allows and that meets [`required_limits`].
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] lists what was found; [`GpuError::NoDevice`] is the driver's refusal.
    pub async fn open(choice: AdapterChoice) -> Result<Self> {
        let found = enumerate().await;
        let best = found
            .iter()
            .filter(|a| required_limits().check_limits(&a.limits()))
            .filter_map(|a| {
                let description = AdapterDescription::new(&a.get_info());
                Some((choice.preference(description.kind)?, a, description))
            })
            .min_by_key(|(preference, ..)| *preference);
        let Some((_, adapter, description)) = best else {
            let names: Vec<String> = found.iter().map(|a| a.get_info().name).collect();
            return Err(GpuError::NoAdapter(format!(
                "{choice:?} was asked for and the machine has [{}]; allow a software adapter \
                 (--allow-software), which a driver such as mesa-vulkan-drivers brings, or use the CPU",
                names.join(", ")
            ))
            .into());
        };
        let (device, queue) = adapter
            .request_device(&wgpu::DeviceDescriptor {
                label: Some("supple"),
                required_features: required_features(),
                required_limits: required_limits(),
                ..Default::default()
            })
            .await
            .map_err(|e| GpuError::NoDevice(e.to_string()))?;
        Ok(Self {
            device,
            queue,
            adapter: description,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn software_is_taken_only_when_allowed() {
        use AdapterKind::{Hardware, Software};
        assert_eq!(AdapterChoice::Hardware.preference(Software), None);
        let either = AdapterChoice::HardwareElseSoftware;
        assert!(either.preference(Hardware) < either.preference(Software));
        assert_eq!(AdapterChoice::Software.preference(Hardware), None);
    }
}
