//! What a world's evaluators on the GPU share: the kernels, compiled once a material law, and one submission a question.

use super::evaluators::AssetEvaluator;
use crate::Result;
use crate::gpu::{Bytes, Submission};
use crate::material::Material;
use crate::math::Stopwatch;
use crate::model::Avatar;
use crate::potential::{GpuKernels, GpuOptions, GpuPotential};
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;

/// The posed skin of an instance where it was computed, to be drawn from without a copy.
#[derive(Clone, Debug)]
pub struct SkinBuffer<'a> {
    /// A `VERTEX | STORAGE` buffer of the instances of an asset; of each vertex 32 bytes: the position in the first 12,
    /// m, and the normal in 12 from the 16th on. A world that grows makes another: ask before each frame.
    pub buffer: &'a wgpu::Buffer,
    /// The same at the step before, in the same bytes of another buffer: for motion vectors. It is the present skin where
    /// [`World::read_previous_skin`](super::World::read_previous_skin) says so.
    pub previous: &'a wgpu::Buffer,
    /// Which bytes are the instance's, from a multiple of 256 on: it may be bound alone as storage.
    pub range: Range<u64>,
    /// What its positions are relative to, m, in the world: draw with this translation.
    pub origin: DVec3,
    /// What the previous positions are relative to, m, in the world.
    pub previous_origin: DVec3,
}

/// A device, and the kernels that were compiled for it so far.
#[derive(Debug)]
pub(super) struct OpenedGpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    /// One for each material law.
    kernels: Vec<GpuKernels>,
}

impl OpenedGpu {
    pub fn new(device: wgpu::Device, queue: wgpu::Queue) -> Self {
        Self {
            device,
            queue,
            kernels: Vec::new(),
        }
    }

    /// Compiles the kernels of the law of `material`, unless they are there.
    pub async fn compile(&mut self, material: &Material) -> Result<()> {
        if self.find(material).is_none() {
            let kernels = GpuKernels::compile(&self.device, material, None).await?;
            self.kernels.push(kernels);
        }
        Ok(())
    }

    fn find(&self, material: &Material) -> Option<&GpuKernels> {
        self.kernels.iter().find(|k| k.are_of(material))
    }

    /// What evaluates `instances` of `avatar`; the first avatar of a law waits for its kernels.
    pub fn potential(
        &mut self,
        avatar: Arc<Avatar>,
        instances: usize,
        options: GpuOptions,
    ) -> Result<GpuPotential> {
        #[cfg(not(target_arch = "wasm32"))]
        pollster::block_on(self.compile(&avatar.material))?;
        let kernels = self.find(&avatar.material).ok_or_else(|| {
            let problem =
                "its law is not compiled yet: await World::compile_kernels before the avatar comes";
            crate::Error::invalid("material", problem)
        })?;
        GpuPotential::with_kernels(
            &self.device,
            &self.queue,
            kernels,
            avatar,
            instances,
            options,
        )
    }
}

/// What the questions to all evaluators on the device go in: one submission and one readback each.
#[derive(Debug)]
pub(super) struct Shared {
    pub submission: Submission,
    /// Time spent waiting for results since the step began, ms.
    pub readback: f64,
}

impl Shared {
    /// `shared`, or another where it has too little room for these; none where there are none.
    pub fn with_room<'a>(
        shared: Option<Self>,
        potentials: impl Iterator<Item = &'a GpuPotential> + Clone,
    ) -> Result<Option<Self>> {
        let Some(first) = potentials.clone().next() else {
            return Ok(None);
        };
        let room = potentials.map(GpuPotential::room_to_read).sum();
        if let Some(shared) = shared.filter(|shared| shared.submission.room() >= room) {
            return Ok(Some(shared));
        }
        Ok(Some(Self {
            submission: first.submission("results of a world's tissue", room)?,
            readback: 0.0,
        }))
    }

    /// Before a question is recorded: one that failed or was dropped is forgotten, save a step's end.
    pub fn begin(&mut self) -> &mut Submission {
        self.submission.cancel_reads();
        &mut self.submission
    }

    /// All that was read back, after each asset has taken what there is of a step's end.
    pub async fn read(&mut self, assets: &mut [AssetEvaluator]) -> Result<Bytes<'_>> {
        assets.iter_mut().for_each(AssetEvaluator::await_end);
        let clock = Stopwatch::start();
        let bytes = self.submission.read().await?;
        self.readback += clock.ms();
        assets.iter_mut().for_each(|asset| asset.take_end(&bytes));
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use crate::Result;
    use crate::collider::Shape;
    use crate::gpu::{AdapterChoice, GpuDevice, pipeline::made};
    use crate::material::Material;
    use crate::model::{RigidBody, State};
    use crate::potential::{Difference, Trial};
    use crate::random_avatar::random_avatar;
    use crate::sim::Members;
    use crate::world::{Backend, World};
    use std::sync::atomic::Ordering;

    fn world() -> Result<World> {
        let gpu = pollster::block_on(GpuDevice::open(AdapterChoice::HardwareElseSoftware))
            .expect("GPU tests need an adapter, such as the one of mesa-vulkan-drivers");
        World::new(Backend::Gpu {
            device: gpu.device,
            queue: gpu.queue,
        })
    }

    #[test]
    fn trials_that_go_in_turns_are_those_of_each_alone() -> Result<()> {
        let _alone = (made::ONE_AT_A_TIME.lock()).unwrap_or_else(|e| e.into_inner());
        let mut world = world()?;
        let ball = Shape::Sphere { radius: 0.05 };
        world.add_body(RigidBody::new("ball", ball, 900.0)?)?;
        // With their bases 24 states, where a submission takes 16.
        for (seed, instances) in [(1, 12), (2, 2)] {
            let avatar = world.add_avatar(random_avatar(seed, 3, 5, 40, 100))?;
            for _ in 0..instances {
                world.add_instance(avatar)?;
            }
        }
        world.step_blocking(0.01)?;
        let bases: Vec<State> = (world.batches.iter())
            .flat_map(|batch| batch.characters.iter().map(|c| c.instance.state.clone()))
            .collect();
        let moved = |(i, state): (usize, &State)| {
            state.moved(&vec![1e-4 * (1 + i) as f64; state.space().dofs()], 1.0)
        };
        let states: Vec<State> = bases.iter().enumerate().map(moved).collect();
        let active = (world.batches.iter())
            .flat_map(|batch| batch.members().zip(&batch.used))
            .filter_map(|(member, used)| used.then_some(member));
        let trials: Vec<Trial<'_>> = active
            .map(|instance| Trial {
                instance,
                base: &bases[instance],
                state: &states[instance],
            })
            .collect();
        assert_eq!(trials.len(), 15);
        let evaluators = &mut world.evaluators;
        let before = evaluators.traffic();
        let mut together = vec![Difference::default(); trials.len()];
        pollster::block_on(evaluators.energy_differences(&trials, &mut together))?;
        let after = evaluators.traffic();
        assert_eq!([0, 1].map(|k| after[k] - before[k]), [2, 2]);
        for (trial, together) in trials.iter().zip(together) {
            let mut alone = [Difference::default()];
            pollster::block_on(evaluators.energy_differences(&[*trial], &mut alone))?;
            assert_eq!(alone, [together]);
            // A body has no tissue.
            assert_eq!(together.energy != 0.0, !trial.state.handles.is_empty());
        }
        Ok(())
    }

    #[test]
    fn what_comes_makes_no_pipeline_but_a_new_law() -> Result<()> {
        let _alone = (made::ONE_AT_A_TIME.lock()).unwrap_or_else(|e| e.into_inner());
        let mut world = world()?;
        let count = || made::COUNT.load(Ordering::Relaxed);
        let before = count();
        let mut small = random_avatar(1, 3, 5, 40, 100);
        let first = world.add_avatar(small.clone())?;
        let one_set = count() - before;
        assert!(one_set > 0);
        for _ in 0..3 {
            world.add_instance(first)?;
        }
        let second = world.add_avatar(random_avatar(2, 4, 8, 90, 150))?;
        world.add_instance(second)?;
        let ball = Shape::Sphere { radius: 0.05 };
        world.add_body(RigidBody::new("ball", ball, 900.0)?)?;
        world.step_blocking(0.01)?;
        assert_eq!(count() - before, one_set);
        let own = small.material.kernels();
        let others = Material::examples().into_iter();
        let others = others.filter(|material| material.kernels() != own);
        for (other, sets) in others.zip(2..) {
            pollster::block_on(world.compile_kernels(&other))?;
            assert_eq!(count() - before, sets * one_set);
            small.material = other;
            world.add_avatar(small.clone())?;
            assert_eq!(count() - before, sets * one_set);
        }
        Ok(())
    }
}
