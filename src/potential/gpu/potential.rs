//! The potential on the GPU: what is made once, and what a host may reach.

use super::buffers::Buffers;
use super::compact::Compact;
use super::contact::Contact;
use super::displacement::Displacement;
use super::elasticity::Elasticity;
use super::energy::Energy;
use super::friction::Friction;
use super::geometric::contact_bytes;
use super::gradient::Gradient;
use super::hessian::Hessian;
use super::normals::Normals;
use super::point_hessian::PointHessian;
use super::pose_blend::PoseBlend;
use super::shared::{BatchState, Collider, Frame, Handle, SkinVertex, Summary};
use super::skin::Skin;
use super::tables::Tables;
use super::{Batch, Sources};
use crate::gpu::{Readback, Waiting};
use crate::model::{Avatar, Space, State};
use crate::potential::{BlockPattern, Evaluation, Potential, StepStart, Trial};
use crate::{Error, Result};
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;

/// What a [`GpuPotential`] makes room for.
#[derive(Clone, Debug)]
pub struct GpuOptions {
    /// Colliders an instance may have.
    pub colliders: usize,
    /// Different meshes that colliders may be of, in all instances; 432 KiB each.
    pub meshes: usize,
    /// Active contacts an instance may have; more are an error.
    pub contacts: usize,
    /// Trials of a line search that go in one submission; more take several.
    pub trials: usize,
    /// Bytes that a scratch buffer may have; states that do not fit go through it in turns.
    pub scratch_bytes: u64,
    /// Who drives the device while a readback is awaited.
    pub waiting: Waiting,
    /// The kernels' texts; `None` takes the library's own.
    pub sources: Option<Sources>,
}

impl Default for GpuOptions {
    fn default() -> Self {
        Self {
            colliders: 8,
            meshes: 1,
            contacts: 2048,
            trials: 8,
            scratch_bytes: 128 << 20,
            waiting: Waiting::default(),
            sources: None,
        }
    }
}

/// What a step of one instance holds on to.
#[derive(Clone, Debug)]
pub(super) struct Start {
    /// The root's place at tⁿ: what positions on the device are relative to.
    pub origin: DVec3,
    pub current: State,
    /// Header of a state of this instance, without its slots.
    pub header: BatchState,
    /// Pose feature of qⁿ where the geometric terms of contact are wanted.
    pub geometric: Option<Vec<f64>>,
}

#[derive(Debug)]
pub(super) struct Stages {
    pub pose_blend: PoseBlend,
    pub displacement: Displacement,
    pub elasticity: Elasticity,
    pub contact: Contact,
    pub friction: Friction,
    pub compact: Compact,
    pub gradient: Gradient,
    pub point_hessian: PointHessian,
    pub hessian: Hessian,
    pub energy: Energy,
    pub skin: Skin,
    pub normals: Normals,
}

/// The tissue's energy for a batch of avatars, evaluated by WGSL kernels on the host's device.
///
/// All buffers, pipelines and bind groups are made by [`GpuPotential::new`]; a step makes none. An
/// evaluation is one submission and one readback.
#[derive(Debug)]
pub struct GpuPotential {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    pub(super) name: String,
    pub(super) avatar: Arc<Avatar>,
    pub(super) pattern: BlockPattern,
    /// Frames that may carry colliders.
    pub(super) body_frames: Vec<u32>,
    /// Whether any collider has had friction so far.
    pub(super) has_friction: bool,
    pub(super) options: GpuOptions,
    pub(super) buffers: Buffers,
    pub(super) stages: Stages,
    pub(super) readback: Readback,
    pub(super) skin_readback: Readback,
    pub(super) starts: Vec<Option<Start>>,
    pub(super) skin_origins: Vec<DVec3>,
    /// Pose features of each instance's drawn skin; empty before it is drawn.
    pub(super) posed_features: Vec<Vec<f32>>,
    // What the next submission uploads; kept to spare allocations.
    pub(super) batch: Vec<BatchState>,
    pub(super) frames: Vec<Frame>,
    pub(super) handles: Vec<Handle>,
    pub(super) colliders: Vec<Collider>,
    pub(super) features: Vec<f32>,
}

impl GpuPotential {
    /// Prepares `instances` avatars on `device`, which needs [`crate::gpu::required_limits`].
    ///
    /// # Errors
    /// [`Error::Invalid`] names what is wrong with the avatar; [`crate::GpuError`] what the device
    /// lacks.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        avatar: Arc<Avatar>,
        instances: usize,
        options: GpuOptions,
    ) -> Result<Self> {
        avatar.validate()?;
        if instances == 0 {
            return Err(Error::invalid("instances", "at least one is needed"));
        }
        let tables = Tables::new(&avatar)?;
        let buffers = Buffers::new(device, queue, &avatar, &tables, instances, &options)?;
        let default_sources = Sources::new(&avatar.material);
        let sources = options.sources.as_ref().unwrap_or(&default_sources);
        let blocks = avatar.space().blocks();
        let stages = Stages {
            pose_blend: PoseBlend::new(device, sources, &buffers)?,
            displacement: Displacement::new(device, sources, &buffers)?,
            elasticity: Elasticity::new(device, sources, &buffers)?,
            contact: Contact::new(device, sources, &buffers)?,
            friction: Friction::new(device, sources, &buffers, options.contacts)?,
            compact: Compact::new(device, sources, &buffers, options.contacts, blocks)?,
            gradient: Gradient::new(device, sources, &buffers, blocks)?,
            point_hessian: PointHessian::new(device, sources, &buffers)?,
            hessian: Hessian::new(device, sources, &buffers)?,
            energy: Energy::new(device, sources, &buffers)?,
            skin: Skin::new(device, sources, &buffers)?,
            normals: Normals::new(device, sources, &buffers)?,
        };
        let summaries = buffers.capacity.states * size_of::<Summary>();
        let results = instances * buffers.result_stride * size_of::<f32>();
        let contacts = instances * contact_bytes(options.contacts);
        let skin_bytes = avatar.skin.len() * size_of::<SkinVertex>();
        let readback = |label, bytes| Readback::new(device, label, bytes as u64, options.waiting);
        Ok(Self {
            readback: readback("evaluation", summaries + results + contacts),
            skin_readback: readback("skin", skin_bytes),
            starts: vec![None; instances],
            skin_origins: vec![DVec3::ZERO; instances],
            posed_features: vec![Vec::new(); instances],
            batch: Vec::with_capacity(buffers.capacity.states),
            frames: Vec::with_capacity(buffers.frames.len()),
            handles: Vec::with_capacity(buffers.handles.len()),
            colliders: Vec::with_capacity(options.colliders),
            features: Vec::with_capacity(buffers.features.len()),
            pattern: tables.pattern,
            body_frames: avatar.body_frames(),
            has_friction: false,
            name: device.adapter_info().name,
            device: device.clone(),
            queue: queue.clone(),
            avatar,
            options,
            buffers,
            stages,
        })
    }

    /// The drawn skin of all instances: a `VERTEX | STORAGE` buffer of [`SkinVertex`], 32 bytes each, the
    /// position in the first 12 and the normal in 12 from the 16th on. Positions are relative to
    /// [`GpuPotential::skin_origin`].
    pub fn skin_buffer(&self) -> &wgpu::Buffer {
        self.buffers.skin_vertices.raw()
    }

    /// Bytes of [`GpuPotential::skin_buffer`] that hold `instance`.
    pub fn skin_range(&self, instance: usize) -> Range<u64> {
        let bytes = (self.avatar.skin.len() * size_of::<SkinVertex>()) as u64;
        instance as u64 * bytes..(instance as u64 + 1) * bytes
    }

    /// What the positions in [`GpuPotential::skin_buffer`] are relative to, in world space: the root's
    /// place. Draw with this translation.
    pub fn skin_origin(&self, instance: usize) -> DVec3 {
        self.skin_origins[instance]
    }

    pub(super) fn submit(
        &self,
        record: impl FnOnce(&Stages, &mut wgpu::ComputePass<'_>),
        copy: impl FnOnce(&mut wgpu::CommandEncoder),
    ) {
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            record(&self.stages, &mut pass);
        }
        copy(&mut encoder);
        self.queue.submit([encoder.finish()]);
    }

    /// The dispatches that `states` states take, those with scratch memory in chunks.
    pub(super) fn chunks(&self, states: usize) -> impl Iterator<Item = Batch> + use<> {
        let lanes = self.buffers.capacity.lanes;
        (0..states.div_ceil(lanes)).map(move |chunk| Batch {
            chunk: chunk as u32,
            states: lanes.min(states - chunk * lanes) as u32,
        })
    }

    /// What a stage left in the buffer that kernels call `name`, for tests that look at one stage alone.
    #[doc(hidden)]
    pub async fn intermediate(&self, name: &str) -> Result<Vec<u8>> {
        let buffer = self.buffers.intermediate(name).ok_or_else(|| {
            Error::invalid("intermediate", format!("there is no buffer `{name}`"))
        })?;
        let readback = Readback::new(&self.device, name, buffer.size(), self.options.waiting);
        self.submit(
            |_, _| {},
            |encoder| readback.record(encoder, buffer, 0..buffer.size(), 0),
        );
        readback
            .read(&self.device, buffer.size(), <[u8]>::to_vec)
            .await
    }
}

impl Potential for GpuPotential {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn space(&self) -> Space {
        self.avatar.space()
    }

    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn instances(&self) -> usize {
        self.starts.len()
    }

    async fn begin_step(&mut self, starts: &[StepStart<'_>], active: &[bool]) -> Result<()> {
        self.begin(starts, active).await
    }

    async fn evaluate(
        &mut self,
        states: &[State],
        active: &[bool],
        out: &mut [Evaluation],
    ) -> Result<()> {
        self.evaluate_states(states, active, out).await
    }

    async fn energy_differences(&mut self, trials: &[Trial<'_>], out: &mut [f64]) -> Result<()> {
        self.compare(trials, out).await
    }

    async fn pose_skin(&mut self, states: &[State]) -> Result<()> {
        self.draw(states).await
    }

    async fn read_skin(
        &mut self,
        instance: usize,
        positions: &mut Vec<DVec3>,
        normals: &mut Vec<DVec3>,
    ) -> Result<()> {
        self.read_posed_skin(instance, positions, normals).await
    }
}
