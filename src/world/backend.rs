//! Where a world's tissue is evaluated.

#[cfg(feature = "gpu")]
use super::gpu::{OpenedGpu, SkinBuffer};
#[cfg(feature = "gpu")]
use crate::gpu::{AdapterChoice, GpuDevice};
use crate::material::Material;
use crate::model::{Avatar, State};
use crate::potential::{BlockPattern, CpuPotential, EvaluationTimings, HessianForm, Potential};
#[cfg(feature = "gpu")]
use crate::potential::{GpuOptions, GpuPotential};
use crate::{Error, Result};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Where a world's tissue is evaluated.
#[derive(Clone, Debug, Default)]
#[non_exhaustive]
pub enum Backend {
    /// On a hardware GPU where there is one, and on the CPU otherwise: [`World::backend`](super::World::backend) says
    /// which. A software GPU is not taken, as the CPU is faster.
    #[default]
    Auto,
    /// In f64 on the CPU.
    Cpu,
    /// On the host's own device, made with at least [`required_limits`](crate::gpu::required_limits).
    #[cfg(feature = "gpu")]
    Gpu {
        /// The device.
        device: wgpu::Device,
        /// Its queue.
        queue: wgpu::Queue,
    },
}

/// A backend that has been found.
#[derive(Debug)]
pub(super) enum Opened {
    Cpu,
    #[cfg(feature = "gpu")]
    Gpu(OpenedGpu),
}

/// What an asset's evaluator must have room for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Room {
    pub instances: usize,
    /// Frames that stand for bodies.
    pub body_slots: usize,
    /// Colliders of an instance, bodies' included.
    pub colliders: usize,
    /// Different meshes of colliders.
    pub meshes: usize,
    /// Fine handles that may be awake at a time, of each instance.
    #[serde(skip)]
    pub fine_slots: usize,
}

impl Room {
    /// Room for both.
    pub fn union(self, other: Self) -> Self {
        Self {
            instances: self.instances.max(other.instances),
            body_slots: self.body_slots.max(other.body_slots),
            colliders: self.colliders.max(other.colliders),
            meshes: self.meshes.max(other.meshes),
            fine_slots: self.fine_slots.max(other.fine_slots),
        }
    }

    /// The same or more, in powers of two, so that what grows one by one is made anew seldom.
    pub fn rounded_up(self) -> Self {
        let up = |n: usize| if n == 0 { 0 } else { n.next_power_of_two() };
        Self {
            instances: up(self.instances),
            body_slots: up(self.body_slots),
            colliders: up(self.colliders),
            meshes: up(self.meshes),
            fine_slots: self.fine_slots,
        }
    }
}

impl Backend {
    pub(super) async fn open(self) -> Result<Opened> {
        match self {
            Self::Cpu => Ok(Opened::Cpu),
            #[cfg(feature = "gpu")]
            Self::Gpu { device, queue } => Ok(Opened::Gpu(OpenedGpu::new(device, queue))),
            #[cfg(feature = "gpu")]
            Self::Auto => Ok(match GpuDevice::open(AdapterChoice::Hardware).await {
                Ok(GpuDevice { device, queue, .. }) => Opened::Gpu(OpenedGpu::new(device, queue)),
                Err(_) => Opened::Cpu,
            }),
            #[cfg(not(feature = "gpu"))]
            Self::Auto => Ok(Opened::Cpu),
        }
    }
}

impl Opened {
    /// Evaluates avatars of one asset; `avatar` has the body slots of `room`. Rigid bodies are evaluated on the CPU.
    #[cfg_attr(not(feature = "gpu"), expect(unused_variables))]
    pub fn evaluator(
        &mut self,
        avatar: &Arc<Avatar>,
        room: Room,
        is_body: bool,
    ) -> Result<Evaluator> {
        let (avatar, instances) = (avatar.clone(), room.instances.max(1));
        match self {
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) if !is_body => {
                let options = GpuOptions {
                    colliders: room.colliders.max(1),
                    meshes: room.meshes.max(1),
                    ..GpuOptions::default()
                };
                let potential = gpu.potential(avatar, instances, options)?;
                Ok(Evaluator::Gpu(Box::new(potential)))
            }
            _ => {
                let potential = CpuPotential::new(avatar, instances)?;
                Ok(Evaluator::Cpu(Box::new(potential)))
            }
        }
    }

    /// How many of the fine handles of `avatar` may be awake at a time where `budget` are asked for; none on the GPU.
    pub fn fine_slots(&self, avatar: &Avatar, budget: usize) -> usize {
        match self {
            // An avatar with slots of its own keeps them.
            Self::Cpu if avatar.fine.slots == 0 => budget.min(avatar.fine.len()),
            _ => 0,
        }
    }

    /// Compiles what tissue of the law of `material` needs; nothing on the CPU.
    pub async fn compile(&mut self, material: &Material) -> Result<()> {
        match self {
            Self::Cpu => material.validate(),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.compile(material).await,
        }
    }

    /// What evaluates, for reports.
    pub fn name(&self) -> String {
        match self {
            Self::Cpu => "cpu".into(),
            #[cfg(feature = "gpu")]
            Self::Gpu(gpu) => gpu.device.adapter_info().name,
        }
    }
}

/// The tissue's energy of the instances of one asset.
pub(super) enum Evaluator {
    Cpu(Box<CpuPotential>),
    #[cfg(feature = "gpu")]
    Gpu(Box<GpuPotential>),
}

/// Calls the same method of either.
macro_rules! either {
    ($evaluator:expr, |$potential:ident| $call:expr) => {
        match $evaluator {
            Evaluator::Cpu($potential) => $call,
            #[cfg(feature = "gpu")]
            Evaluator::Gpu($potential) => $call,
        }
    };
}

impl Evaluator {
    /// Itself, on the CPU.
    pub fn on_cpu(&mut self) -> Option<&mut CpuPotential> {
        match self {
            Self::Cpu(potential) => Some(potential),
            #[cfg(feature = "gpu")]
            Self::Gpu(_) => None,
        }
    }

    /// Itself, on the GPU.
    #[cfg(feature = "gpu")]
    pub fn on_gpu(&mut self) -> Option<&mut GpuPotential> {
        match self {
            Self::Cpu(_) => None,
            Self::Gpu(potential) => Some(potential),
        }
    }

    pub fn pattern(&self) -> &BlockPattern {
        either!(self, |potential| potential.pattern())
    }

    pub fn hessian_form(&self) -> HessianForm {
        either!(self, |potential| potential.hessian_form())
    }

    pub fn timings(&self) -> EvaluationTimings {
        either!(self, |potential| potential.timings())
    }

    pub async fn read_skin(
        &mut self,
        instance: usize,
        positions: &mut Vec<DVec3>,
        normals: &mut Vec<DVec3>,
    ) -> Result<()> {
        either!(self, |potential| potential
            .read_skin(instance, positions, normals)
            .await)
    }

    pub async fn read_previous_skin(
        &mut self,
        instance: usize,
        positions: &mut Vec<DVec3>,
    ) -> Result<()> {
        either!(self, |potential| potential
            .read_previous_skin(instance, positions)
            .await)
    }

    pub async fn read_contacts(
        &mut self,
        instance: usize,
        state: &State,
        forces: &mut Vec<DVec3>,
        pressures: &mut Vec<f64>,
    ) -> Result<()> {
        either!(self, |potential| potential
            .read_contacts(instance, state, forces, pressures)
            .await)
    }

    /// Where the skin of an instance is on the device; none on the CPU.
    #[cfg(feature = "gpu")]
    pub fn skin_buffer(&self, instance: usize) -> Option<SkinBuffer<'_>> {
        match self {
            Self::Cpu(_) => None,
            Self::Gpu(potential) => Some(SkinBuffer {
                buffer: potential.skin_buffer(),
                previous: potential.previous_skin_buffer(),
                range: potential.skin_range(instance),
                origin: potential.skin_origin(instance),
                previous_origin: potential.previous_skin_origin(instance),
            }),
        }
    }
}

/// The error of a key that names nothing (any more).
pub(super) fn gone(what: &str) -> Error {
    Error::invalid(
        what,
        "this world has none of that key: it was removed, or the key is another world's",
    )
}
