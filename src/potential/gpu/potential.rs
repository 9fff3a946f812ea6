//! The potential on the GPU as Newton sees it: each question recorded, submitted and awaited.

use super::kernels::GpuKernels;
use super::options::GpuOptions;
use super::recorder::Recorder;
use super::shared::SkinVertex;
use crate::gpu::{AdapterDescription, Bytes, Listener, Patience, Submission};
use crate::math::Stopwatch;
use crate::model::{Avatar, Space, State};
use crate::potential::{
    BlockPattern, Difference, Evaluation, EvaluationTimings, Potential, PreviousSkin, StepEnd,
    StepStart, Trial,
};
use crate::{Error, GpuError, Result};
use glam::{DVec3, Vec3};
use std::ops::Range;
use std::sync::Arc;

/// The tissue's energy for a batch of avatars, evaluated by WGSL kernels on the host's device.
///
/// All buffers and bind groups are made by [`GpuPotential::with_kernels`], and pipelines before that, by
/// [`GpuKernels`]; a step makes none. A step without a line search is two submissions and one readback: its start and the
/// evaluation, and the posed skin.
#[derive(Debug)]
pub struct GpuPotential {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    name: String,
    pub(super) recorder: Recorder,
    /// What is recorded and not yet sent: a step's start waits here for its first evaluation.
    pub(super) submission: Submission,
    skin_submission: Submission,
    timings: EvaluationTimings,
}

impl GpuPotential {
    /// Prepares `instances` avatars on `device`, which needs [`crate::gpu::required_limits`], with kernels of their own.
    /// In a browser, where errors of pipelines come later, there is [`GpuPotential::with_kernels`] alone.
    ///
    /// # Errors
    /// [`Error::Invalid`] names what is wrong with the avatar; [`crate::GpuError`] what the device lacks.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        avatar: Arc<Avatar>,
        instances: usize,
        options: GpuOptions,
    ) -> Result<Self> {
        avatar.validate()?;
        let kernels = GpuKernels::compile_blocking(device, &avatar.material, None)?;
        Self::with_kernels(device, queue, &kernels, avatar, instances, options)
    }

    /// Prepares `instances` avatars on `device` with `kernels` that other potentials may have as well: makes buffers and
    /// bind groups, and no pipeline.
    ///
    /// # Errors
    /// [`Error::Invalid`] names what is wrong with the avatar, or that the kernels are of another device or material law;
    /// [`crate::GpuError::Limit`] what the device has no room for, and how many instances it has room for; [`GpuError::Memory`] that its
    /// memory is full.
    pub fn with_kernels(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        kernels: &GpuKernels,
        avatar: Arc<Avatar>,
        instances: usize,
        options: GpuOptions,
    ) -> Result<Self> {
        let patience = Patience {
            waiting: options.waiting,
            timeout: options.timeout,
        };
        let listener = Listener::new(device);
        let recorder = Recorder::new(device, queue, kernels, avatar, instances, options)?;
        let submission = |label, bytes| Submission::new(device, queue, label, bytes, patience);
        let results = submission("results of the tissue", recorder.room_to_read())?;
        let skin_submission = submission("posed skin", recorder.skin_range(0).end)?;
        memory_error(listener)?;
        Ok(Self {
            submission: results,
            skin_submission,
            name: AdapterDescription::new(&device.adapter_info()).name,
            device: device.clone(),
            queue: queue.clone(),
            recorder,
            timings: EvaluationTimings::default(),
        })
    }

    /// The posed skin of all instances: a `VERTEX | STORAGE` buffer of [`SkinVertex`], 32 bytes each, the
    /// position in the first 12 and the normal in 12 from the 16th on. Positions are relative to
    /// [`GpuPotential::skin_origin`].
    pub fn skin_buffer(&self) -> &wgpu::Buffer {
        self.recorder.buffers.common.skin_vertices.raw()
    }

    /// Bytes of [`GpuPotential::skin_buffer`] that hold `instance`. They begin at a multiple of 256, so that a host may bind
    /// them alone.
    pub fn skin_range(&self, instance: usize) -> Range<u64> {
        self.recorder.skin_range(instance)
    }

    /// What the positions in [`GpuPotential::skin_buffer`] are relative to, in world space: the root's
    /// place. Draw with this translation.
    pub fn skin_origin(&self, instance: usize) -> DVec3 {
        self.recorder.skin_origins[instance]
    }

    /// The posed skin of the step before, in the same bytes as [`GpuPotential::skin_buffer`]'s.
    pub(crate) fn previous_skin_buffer(&self) -> &wgpu::Buffer {
        self.recorder.buffers.common.previous_skin_vertices.raw()
    }

    /// What the positions in [`GpuPotential::previous_skin_buffer`] are relative to.
    pub(crate) fn previous_skin_origin(&self, instance: usize) -> DVec3 {
        self.recorder.previous_skin_origins[instance]
    }

    /// Positions (m, world) of the posed skin of the step before.
    pub(crate) async fn read_previous_skin(
        &mut self,
        instance: usize,
        positions: &mut Vec<DVec3>,
    ) -> Result<()> {
        self.recorder.checks.instance(instance)?;
        let origin = self.previous_skin_origin(instance);
        let vertices = self.previous_skin_buffer().clone();
        let bytes = self.read_vertices(&vertices, instance).await?;
        positions.clear();
        let position = |v: SkinVertex| origin + Vec3::from_array(v.position).as_dvec3();
        positions.extend(vertices_of(&bytes).map(position));
        Ok(())
    }

    /// What `vertices`, a buffer of skins, holds of an instance.
    async fn read_vertices(
        &mut self,
        vertices: &wgpu::Buffer,
        instance: usize,
    ) -> Result<Bytes<'_>> {
        let range = self.skin_range(instance);
        let at = (self.skin_submission).reserve(range.end - range.start)?;
        if !at.is_empty() {
            self.skin_submission.copy(vertices, range, at.start);
        }
        self.skin_submission.read().await
    }

    /// Another submission, with room for `bytes` to read back, for who steps several potentials together.
    pub(crate) fn submission(&self, label: &str, bytes: u64) -> Result<Submission> {
        let listener = Listener::new(&self.device);
        let patience = self.recorder.patience();
        let submission = Submission::new(&self.device, &self.queue, label, bytes, patience)?;
        memory_error(listener)?;
        Ok(submission)
    }

    /// Bytes that a question reads back at most.
    pub(crate) fn room_to_read(&self) -> u64 {
        self.recorder.room_to_read()
    }

    /// For who steps several potentials together: records into a [`Submission`] of the caller's, which must have been
    /// sent before anything else is asked of this potential. What waits in its own is sent first.
    #[doc(hidden)]
    pub fn recorder(&mut self) -> &mut Recorder {
        self.submission.flush();
        &mut self.recorder
    }

    /// What a stage left in the buffer that kernels call `name`, for tests that look at one stage alone.
    #[doc(hidden)]
    pub async fn intermediate(&mut self, name: &str) -> Result<Vec<u8>> {
        let written =
            |buffer: &&wgpu::Buffer| buffer.usage().contains(wgpu::BufferUsages::COPY_SRC);
        let buffer = (self.recorder.buffers.find(name).filter(written)).ok_or_else(|| {
            let problem = format!("there is no buffer `{name}` that kernels write");
            Error::invalid("intermediate", problem)
        })?;
        self.submission.flush();
        let mut submission = Submission::new(
            &self.device,
            &self.queue,
            name,
            buffer.size(),
            self.recorder.patience(),
        )?;
        let at = submission.reserve(buffer.size())?.start;
        submission.copy(buffer, 0..buffer.size(), at);
        Ok(submission.read().await?.to_vec())
    }
}

/// The vertices in `bytes`.
fn vertices_of(bytes: &[u8]) -> impl Iterator<Item = SkinVertex> {
    let vertices = bytes.chunks_exact(size_of::<SkinVertex>());
    vertices.map(bytemuck::pod_read_unaligned)
}

/// What the driver refused since.
fn memory_error(listener: Listener) -> Result<()> {
    let heard = listener.heard();
    // In a browser it comes later, as a lost device.
    if cfg!(not(target_arch = "wasm32"))
        && let Some(message) = pollster::block_on(heard)
    {
        return Err(GpuError::Memory(message).into());
    }
    Ok(())
}

impl Potential for GpuPotential {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn space(&self) -> Space {
        self.recorder.avatar.space()
    }

    fn pattern(&self) -> &BlockPattern {
        &self.recorder.pattern
    }

    fn instances(&self) -> usize {
        self.recorder.starts.len()
    }

    /// The time until results were there is all `readback`: the host sees nothing of the stages before.
    fn timings(&self) -> EvaluationTimings {
        self.timings
    }

    /// Only records: the first evaluation submits it with itself, or else whatever comes next.
    async fn begin_step(&mut self, starts: &[StepStart<'_>], active: &[bool]) -> Result<()> {
        self.timings = EvaluationTimings::default();
        (self.recorder).record_begin_step(starts, active, &mut self.submission)
    }

    async fn evaluate(
        &mut self,
        states: &[State],
        active: &[bool],
        out: &mut [Evaluation],
    ) -> Result<()> {
        self.recorder.checks.count("out", out.len())?;
        (self.recorder).record_evaluate(states, active, &mut self.submission)?;
        let clock = Stopwatch::start();
        let bytes = self.submission.read().await?;
        self.timings.readback += clock.ms();
        self.recorder.finish_evaluate(&bytes, states, out)
    }

    async fn end_step(
        &mut self,
        states: &[State],
        wanted: &[bool],
        out: &mut [StepEnd],
    ) -> Result<()> {
        self.recorder.checks.count("out", out.len())?;
        (self.recorder).record_end_step(states, wanted, &mut self.submission)?;
        let clock = Stopwatch::start();
        let bytes = self.submission.read().await?;
        self.timings.readback += clock.ms();
        self.recorder.finish_end_step(&bytes, out)
    }

    async fn energy_differences(
        &mut self,
        trials: &[Trial<'_>],
        out: &mut [Difference],
    ) -> Result<()> {
        let begun = |i: usize| self.recorder.starts[i].is_some();
        self.recorder.checks.trials(trials, out.len(), begun)?;
        let mut done = 0;
        while done < trials.len() {
            let (trials, submission) = (&trials[done..], &mut self.submission);
            let count = (self.recorder).record_energy_differences(trials, submission)?;
            let clock = Stopwatch::start();
            let bytes = self.submission.read().await?;
            self.timings.readback += clock.ms();
            let out = &mut out[done..done + count];
            self.recorder.finish_energy_differences(&bytes, out)?;
            done += count;
        }
        Ok(())
    }

    /// Submits: what is drawn from may be used by the host's next submission.
    async fn pose_skin(
        &mut self,
        states: &[State],
        offsets: &[&[[f32; 3]]],
        previous: &[PreviousSkin],
    ) -> Result<()> {
        let submission = &mut self.submission;
        (self.recorder).record_pose_skin(states, offsets, previous, submission)?;
        self.submission.flush();
        Ok(())
    }

    async fn read_skin(
        &mut self,
        instance: usize,
        positions: &mut Vec<DVec3>,
        normals: &mut Vec<DVec3>,
    ) -> Result<()> {
        self.recorder.checks.instance(instance)?;
        let origin = self.skin_origin(instance);
        let vertices = self.recorder.buffers.common.skin_vertices.raw().clone();
        let bytes = self.read_vertices(&vertices, instance).await?;
        positions.clear();
        normals.clear();
        for vertex in vertices_of(&bytes) {
            positions.push(origin + Vec3::from_array(vertex.position).as_dvec3());
            normals.push(Vec3::from_array(vertex.normal).as_dvec3());
        }
        Ok(())
    }

    async fn read_contacts(
        &mut self,
        instance: usize,
        state: &State,
        forces: &mut Vec<DVec3>,
        pressures: &mut Vec<f64>,
    ) -> Result<()> {
        (self.recorder).record_contacts(instance, state, &mut self.submission)?;
        let bytes = self.submission.read().await?;
        self.recorder.finish_contacts(&bytes, forces, pressures)
    }
}
