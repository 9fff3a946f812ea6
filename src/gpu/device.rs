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
    /// A graphics card with memory of its own.
    Discrete,
    /// A GPU that shares the CPU's memory.
    Integrated,
    /// A part of a GPU, in a virtual machine.
    Virtual,
    /// A CPU that plays a GPU (lavapipe, SwiftShader, WARP).
    Software,
    /// A device that does not say; OpenGL drivers often do not, and browsers never.
    Unknown,
}

/// What an adapter says of itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AdapterDescription {
    /// The device's name; of a browser that keeps it to itself, `webgpu adapter`.
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
        let backend = info.backend.to_string();
        Self {
            name: match info.name.as_str() {
                "" => format!("{backend} adapter"),
                name => name.to_owned(),
            },
            backend,
            kind: match info.device_type {
                T::DiscreteGpu => AdapterKind::Discrete,
                T::IntegratedGpu => AdapterKind::Integrated,
                T::VirtualGpu => AdapterKind::Virtual,
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
    /// Whether an adapter of `kind` is in question.
    fn allows(self, kind: AdapterKind) -> bool {
        match self {
            Self::Hardware => kind != AdapterKind::Software,
            Self::HardwareElseSoftware => true,
            Self::Software => kind == AdapterKind::Software,
        }
    }
}

/// Smaller is better.
fn rank(kind: AdapterKind, preference: wgpu::PowerPreference) -> u32 {
    let frugal = preference == wgpu::PowerPreference::LowPower;
    match kind {
        AdapterKind::Discrete => u32::from(frugal),
        AdapterKind::Integrated => u32::from(!frugal),
        AdapterKind::Virtual => 2,
        AdapterKind::Unknown => 3,
        AdapterKind::Software => 4,
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
    enumerate(wgpu::PowerPreference::HighPerformance)
        .await
        .iter()
        .map(|a| AdapterDescription::new(&a.get_info()))
        .collect()
}

/// What there is; a browser shows one, which fits `preference`.
async fn enumerate(preference: wgpu::PowerPreference) -> Vec<wgpu::Adapter> {
    let instance =
        wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    if cfg!(target_arch = "wasm32") {
        let options = wgpu::RequestAdapterOptions {
            power_preference: preference,
            ..Default::default()
        };
        return instance
            .request_adapter(&options)
            .await
            .into_iter()
            .collect();
    }
    instance.enumerate_adapters(wgpu::Backends::all()).await
}

/// [`required_limits`], with buffers as large as an adapter of these limits has them: a potential then has room for more
/// instances.
fn wanted_limits(adapter: &wgpu::Limits) -> wgpu::Limits {
    wgpu::Limits {
        max_buffer_size: adapter.max_buffer_size,
        max_storage_buffer_binding_size: adapter.max_storage_buffer_binding_size,
        ..required_limits()
    }
}

impl GpuDevice {
    /// Opens the best adapter that `choice` allows and that meets [`required_limits`]: a discrete GPU before an integrated
    /// one, and a software one last. Its buffers may be as large as the adapter has them.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`] lists what was found; [`GpuError::NoDevice`] is the driver's refusal.
    pub async fn open(choice: AdapterChoice) -> Result<Self> {
        Self::open_preferring(choice, wgpu::PowerPreference::HighPerformance).await
    }

    /// [`GpuDevice::open`] with a preference: for low power an integrated GPU comes before a discrete one.
    ///
    /// # Errors
    /// As [`GpuDevice::open`].
    pub async fn open_preferring(
        choice: AdapterChoice,
        preference: wgpu::PowerPreference,
    ) -> Result<Self> {
        let found = enumerate(preference).await;
        let best = found
            .iter()
            .filter(|a| required_limits().check_limits(&a.limits()))
            .filter_map(|a| {
                let description = AdapterDescription::new(&a.get_info());
                let rank = rank(description.kind, preference);
                (choice.allows(description.kind)).then_some((rank, a, description))
            })
            .min_by_key(|(rank, ..)| *rank);
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
                required_limits: wanted_limits(&adapter.limits()),
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
        use AdapterKind::{Discrete, Integrated, Software, Unknown, Virtual};
        let hardware = [Discrete, Integrated, Virtual, Unknown];
        for kind in hardware {
            assert!(AdapterChoice::Hardware.allows(kind));
            assert!(AdapterChoice::HardwareElseSoftware.allows(kind));
            assert!(!AdapterChoice::Software.allows(kind));
        }
        assert!(!AdapterChoice::Hardware.allows(Software));
        assert!(AdapterChoice::HardwareElseSoftware.allows(Software));
        assert!(AdapterChoice::Software.allows(Software));
    }

    #[test]
    fn adapters_are_ranked_by_preference_and_software_is_last() {
        use AdapterKind::{Discrete, Integrated, Software, Unknown, Virtual};
        use wgpu::PowerPreference::{HighPerformance, LowPower, None};
        for preference in [None, HighPerformance, LowPower] {
            let mut kinds = [Software, Unknown, Virtual, Integrated, Discrete];
            kinds.sort_by_key(|&kind| rank(kind, preference));
            let first = match preference {
                LowPower => [Integrated, Discrete],
                _ => [Discrete, Integrated],
            };
            assert_eq!(kinds[..2], first, "{preference:?}");
            assert_eq!(kinds[2..], [Virtual, Unknown, Software], "{preference:?}");
        }
    }

    #[test]
    fn a_nameless_adapter_has_a_name() {
        let info = wgpu::AdapterInfo::new(wgpu::DeviceType::Other, wgpu::Backend::BrowserWebGpu);
        assert_eq!(AdapterDescription::new(&info).name, "webgpu adapter");
    }
}
