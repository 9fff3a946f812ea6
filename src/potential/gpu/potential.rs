//! The potential on the GPU: what is made once, and what a host may reach.

use super::buffers::Buffers;
use super::dispatch::Batch;
use super::options::GpuOptions;
use super::shared::{BatchState, Collider, Frame, Handle, SkinVertex, Summary};
use super::sizes::Sizes;
use super::sources::Sources;
use super::stages::Stages;
use super::tables::Tables;
use crate::gpu::Readback;
use crate::model::{Avatar, State};
use crate::potential::BlockPattern;
use crate::potential::checks::Checks;
use crate::{Error, Result};
use glam::DVec3;
use std::ops::Range;
use std::sync::Arc;

/// What a step of one instance holds on to.
#[derive(Clone, Debug)]
pub(super) struct Start {
    /// The root's place at tⁿ: what positions on the device are relative to.
    pub origin: DVec3,
    pub current: State,
    /// A state of this instance in a batch, without its slots.
    pub batch_state: BatchState,
    /// Which frames are prescribed; empty where none is.
    pub prescribed: Vec<bool>,
    /// Pose feature of qⁿ where the geometric terms of contact are wanted.
    pub geometric: Option<Vec<f64>>,
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
    pub(super) checks: Checks,
    /// Whether any collider has had friction so far.
    pub(super) has_friction: bool,
    /// Whether more pairs of vertex and collider than there is room for might have touched so far.
    pub(super) selects: bool,
    /// Whether any frame has been prescribed so far.
    pub(super) has_prescribed: bool,
    pub(super) options: GpuOptions,
    pub(super) buffers: Buffers,
    pub(super) stages: Stages,
    pub(super) readback: Readback,
    pub(super) skin_readback: Readback,
    pub(super) starts: Vec<Option<Start>>,
    pub(super) skin_origins: Vec<DVec3>,
    /// Pose features of each instance's posed skin; empty before it is posed.
    pub(super) posed_features: Vec<Vec<f32>>,
    // What the next submission uploads; kept to spare allocations.
    pub(super) batch: Vec<BatchState>,
    pub(super) frames: Vec<Frame>,
    pub(super) handles: Vec<Handle>,
    pub(super) colliders: Vec<Collider>,
    pub(super) features: Vec<f32>,
    pub(super) prescribed: Vec<u32>,
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
        let sizes = Sizes::new(device, &avatar, &tables, instances, &options)?;
        let buffers = Buffers::new(device, queue, &avatar, &tables, sizes, &options)?;
        let default_sources = Sources::new(&avatar.material);
        let sources = options.sources.as_ref().unwrap_or(&default_sources);
        let stages = Stages::new(device, sources, &buffers)?;
        let summaries = sizes.states * size_of::<Summary>();
        let results = instances * sizes.result * size_of::<f32>();
        let contacts = instances * sizes.contact_bytes();
        let skin_bytes = sizes.vertices * size_of::<SkinVertex>();
        let readback = |label, bytes| Readback::new(device, label, bytes as u64, options.waiting);
        Ok(Self {
            readback: readback("evaluation", summaries + results + contacts),
            skin_readback: readback("skin", skin_bytes),
            starts: vec![None; instances],
            skin_origins: vec![DVec3::ZERO; instances],
            posed_features: vec![Vec::new(); instances],
            batch: Vec::with_capacity(sizes.states),
            frames: Vec::with_capacity(buffers.common.frames.len()),
            handles: Vec::with_capacity(buffers.common.handles.len()),
            colliders: Vec::with_capacity(options.colliders),
            features: Vec::with_capacity(buffers.common.pose_features.len()),
            prescribed: Vec::with_capacity(buffers.common.prescribed.len()),
            pattern: tables.pattern,
            checks: Checks::new(&avatar, instances),
            has_friction: false,
            selects: false,
            has_prescribed: false,
            name: device.adapter_info().name,
            device: device.clone(),
            queue: queue.clone(),
            avatar,
            options,
            buffers,
            stages,
        })
    }

    /// The posed skin of all instances: a `VERTEX | STORAGE` buffer of [`SkinVertex`], 32 bytes each, the
    /// position in the first 12 and the normal in 12 from the 16th on. Positions are relative to
    /// [`GpuPotential::skin_origin`].
    pub fn skin_buffer(&self) -> &wgpu::Buffer {
        self.buffers.common.skin_vertices.raw()
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
        let size = self.buffers.sizes.chunk_size;
        (0..states.div_ceil(size)).map(move |chunk| Batch {
            chunk: chunk as u32,
            states: size.min(states - chunk * size) as u32,
        })
    }

    /// What a stage left in the buffer that kernels call `name`, for tests that look at one stage alone.
    #[doc(hidden)]
    pub async fn intermediate(&self, name: &str) -> Result<Vec<u8>> {
        let written =
            |buffer: &&wgpu::Buffer| buffer.usage().contains(wgpu::BufferUsages::COPY_SRC);
        let buffer = (self.buffers.find(name).filter(written)).ok_or_else(|| {
            let problem = format!("there is no buffer `{name}` that kernels write");
            Error::invalid("intermediate", problem)
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
