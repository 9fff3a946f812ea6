//! The kernels compiled for a device: once for all avatars whose tissue follows the same material law.

use super::sources::Sources;
use super::stage::StagePipelines;
use super::stages::INCLUDES;
use crate::gpu::{Pipeline, Shader};
use crate::material::Material;
use crate::{Error, Result};
use std::sync::Arc;

/// Uniforms of which a dispatch binds one item.
const DYNAMIC: &[&str] = &["chunk"];

/// All kernels, compiled for a device and a material law. Clones share them.
///
/// The texts depend on the law alone (its parameters are in a buffer), so potentials of any avatars with that law, and of
/// any number of instances, are made from the same kernels and make no pipeline of their own.
#[derive(Clone, Debug)]
pub struct GpuKernels(Arc<Compiled>);

#[derive(Debug)]
struct Compiled {
    device: wgpu::Device,
    /// The law, by the files of its texts.
    material: &'static [&'static str],
    stages: Vec<StagePipelines>,
}

impl GpuKernels {
    /// Compiles the kernels for tissue of `material`'s law on `device`, which needs [`crate::gpu::required_limits`]; on as
    /// many threads as there are, with the feature `threads`. Natively the future is ready when it is first asked; in a
    /// browser it waits for the driver's answers. What `cache` (of this device) holds need not be compiled again; the
    /// caller may store it afterwards.
    ///
    /// # Errors
    /// [`crate::GpuError::Shader`] of the first kernel that the driver refuses, [`crate::GpuError::Limit`] of what the
    /// device lacks.
    pub async fn compile(
        device: &wgpu::Device,
        material: &Material,
        cache: Option<&wgpu::PipelineCache>,
    ) -> Result<Self> {
        Self::compile_sources(device, &Sources::new(material), cache).await
    }

    /// [`GpuKernels::compile`] where there is no executor.
    ///
    /// # Errors
    /// As [`GpuKernels::compile`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn compile_blocking(
        device: &wgpu::Device,
        material: &Material,
        cache: Option<&wgpu::PipelineCache>,
    ) -> Result<Self> {
        pollster::block_on(Self::compile(device, material, cache))
    }

    /// [`GpuKernels::compile`] from other texts, for tests that break them.
    #[doc(hidden)]
    pub async fn compile_sources(
        device: &wgpu::Device,
        sources: &Sources,
        cache: Option<&wgpu::PipelineCache>,
    ) -> Result<Self> {
        let handed_over = each(INCLUDES.len(), |i| {
            let (name, includes) = INCLUDES[i];
            Ok::<_, Error>(sources.module(name, includes)?.shader(device))
        });
        let mut shaders: Vec<Shader> = Vec::new();
        for shader in handed_over {
            let (shader, taken) = shader?;
            taken.await?;
            shaders.push(shader);
        }
        let entries: Vec<(usize, &str)> = (shaders.iter().enumerate())
            .flat_map(|(stage, shader)| shader.module().entry_points().map(move |e| (stage, e)))
            .collect();
        let compiled = each(entries.len(), |i| {
            let (stage, entry) = entries[i];
            shaders[stage].pipeline(entry, DYNAMIC, cache)
        });
        let named = |&(name, _): &(&'static str, _)| StagePipelines {
            name,
            entries: Vec::new(),
        };
        let mut stages: Vec<StagePipelines> = INCLUDES.iter().map(named).collect();
        for ((stage, entry), pipeline) in entries.into_iter().zip(compiled) {
            let (pipeline, taken): (Pipeline, _) = pipeline?;
            taken.await?;
            stages[stage].entries.push((entry.to_owned(), pipeline));
        }
        Ok(Self(Arc::new(Compiled {
            device: device.clone(),
            material: sources.material(),
            stages,
        })))
    }

    /// That they are of `device`, as far as wgpu tells devices apart (not those of two instances of it), and of the law of `material`.
    pub(super) fn check(&self, device: &wgpu::Device, material: &Material) -> Result<()> {
        if self.0.device != *device {
            let problem = "were compiled for another device: compile them for this one";
            return Err(Error::invalid("kernels", problem));
        }
        if !self.are_of(material) {
            let problem = "were compiled for another material law: compile them for this avatar's";
            return Err(Error::invalid("kernels", problem));
        }
        Ok(())
    }

    /// Whether they are of the law of `material`.
    pub(crate) fn are_of(&self, material: &Material) -> bool {
        self.0.material == material.kernels()
    }

    pub(super) fn stages(&self) -> &[StagePipelines] {
        &self.0.stages
    }
}

/// `f(i)` for `i` in `0..count`, at the same time where there are threads.
#[cfg(not(target_arch = "wasm32"))]
fn each<T: Send>(count: usize, f: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    crate::math::in_pool(|| crate::math::par_map(count, f))
}

/// What a browser hands out stays on its thread.
#[cfg(target_arch = "wasm32")]
fn each<T>(count: usize, f: impl Fn(usize) -> T) -> Vec<T> {
    (0..count).map(f).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::{AdapterChoice, GpuDevice, pipeline::made};
    use crate::potential::{GpuOptions, GpuPotential};
    use crate::random_avatar::random_avatar;
    use std::sync::atomic::Ordering;

    #[test]
    fn potentials_with_kernels_make_no_pipeline() {
        let _alone = made::ONE_AT_A_TIME
            .lock()
            .unwrap_or_else(|e| e.into_inner());
        let gpu = pollster::block_on(GpuDevice::open(AdapterChoice::HardwareElseSoftware))
            .expect("GPU tests need an adapter, such as the one of mesa-vulkan-drivers");
        let (device, queue) = (&gpu.device, &gpu.queue);
        let count = || made::COUNT.load(Ordering::Relaxed);
        let [small, large] =
            [(3, 5, 40, 100), (4, 8, 90, 150)].map(|(bones, handles, points, skin)| {
                Arc::new(random_avatar(1, bones, handles, points, skin))
            });
        let before = count();
        let kernels = GpuKernels::compile_blocking(device, &small.material, None).unwrap();
        let one_set = count() - before;
        let held: usize = kernels.stages().iter().map(|s| s.entries.len()).sum();
        assert!(one_set > 0);
        assert_eq!(one_set, held);
        for (avatar, instances) in [(&small, 1), (&small, 3), (&large, 2)] {
            let (avatar, options) = (avatar.clone(), GpuOptions::default());
            GpuPotential::with_kernels(device, queue, &kernels, avatar, instances, options)
                .unwrap();
        }
        assert_eq!(count() - before, one_set);
        GpuPotential::new(device, queue, small, 1, GpuOptions::default()).unwrap();
        assert_eq!(count() - before, 2 * one_set);
    }
}
