//! What a batch of avatars has on the device, made once, and how its questions are recorded.

use super::buffers::Buffers;
use super::dispatch::Batch;
use super::kernels::GpuKernels;
use super::options::GpuOptions;
use super::shared::{BatchState, Collider, Frame, Handle, PastFrame, PastHandle, SkinVertex};
use super::sizes::Sizes;
use super::stages::Stages;
use super::tables::Tables;
use crate::gpu::{Patience, Submission};
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
    /// What x̄ of the skin is made of, where the geometric terms of contact are wanted.
    pub geometric: Option<SkinRest>,
}

/// Pose feature of qⁿ, and the offsets of the skin.
#[derive(Clone, Debug)]
pub(super) struct SkinRest {
    pub feature: Vec<f64>,
    pub offsets: Vec<[f32; 3]>,
}

/// Records the stages for a batch of avatars into submissions, and unpacks what they bring back.
///
/// Each `record_*` checks, uploads, and records into a [`Submission`], which may be others' as well; each `finish_*` takes
/// all bytes that the submission read back, and finds its own in them. Between the two no other is recorded, save that a
/// step's end may be read back with the first results of the next step.
#[derive(Debug)]
pub struct Recorder {
    pub(super) queue: wgpu::Queue,
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
    pub(super) starts: Vec<Option<Start>>,
    pub(super) skin_origins: Vec<DVec3>,
    pub(super) previous_skin_origins: Vec<DVec3>,
    /// Pose features of each instance's posed skin; empty before it is posed.
    pub(super) posed_features: Vec<Vec<f32>>,
    /// The offsets of each instance's skin that the device has.
    pub(super) offsets: Vec<Vec<[f32; 3]>>,
    /// The recordings in which the parts of the uploads were last written: the starts', the states', and that of the
    /// states that are posed.
    starts_recording: u64,
    states_recording: u64,
    poses_recording: u64,
    /// The recording in which offsets were last read or written.
    offsets_recording: u64,
    /// Where its results are among all that the submission reads back.
    pub(super) results: Range<usize>,
    /// Likewise of a step's end, which may come back with the next step's first results, and whose they are.
    pub(super) ends: Range<usize>,
    pub(super) ended: Vec<u32>,
    /// Whether any of the tissue damps.
    pub(super) damped: bool,
    /// Longest φ that is sent to the device, m.
    pub(super) longest_handle: f32,
    // What the next submission uploads; kept to spare allocations.
    pub(super) batch: Vec<BatchState>,
    pub(super) frames: Vec<Frame>,
    pub(super) handles: Vec<Handle>,
    pub(super) past_frames: Vec<PastFrame>,
    pub(super) past_handles: Vec<PastHandle>,
    pub(super) colliders: Vec<Collider>,
    pub(super) features: Vec<f32>,
    pub(super) prescribed: Vec<u32>,
    /// Of the trials: which measure from a base of their own, which base each has, and which are beyond all bounds.
    pub(super) bases: Vec<usize>,
    pub(super) base_of: Vec<usize>,
    pub(super) beyond: Vec<bool>,
}

impl Recorder {
    pub(super) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        kernels: &GpuKernels,
        avatar: Arc<Avatar>,
        instances: usize,
        options: GpuOptions,
    ) -> Result<Self> {
        avatar.validate()?;
        if instances == 0 {
            return Err(Error::invalid("instances", "at least one is needed"));
        }
        kernels.check(device, &avatar.material)?;
        let tables = Tables::new(&avatar)?;
        let damped = avatar.is_damped();
        let sizes = Sizes::new(&device.limits(), &avatar, &tables, instances, &options);
        let buffers = Buffers::new(device, queue, &avatar, &tables, sizes, &options)?;
        Ok(Self {
            damped,
            stages: Stages::new(kernels.stages(), &buffers)?,
            starts: vec![None; instances],
            skin_origins: vec![DVec3::ZERO; instances],
            previous_skin_origins: vec![DVec3::ZERO; instances],
            posed_features: vec![Vec::new(); instances],
            offsets: vec![Vec::new(); instances],
            starts_recording: 0,
            states_recording: 0,
            poses_recording: 0,
            offsets_recording: 0,
            results: 0..0,
            ends: 0..0,
            ended: Vec::with_capacity(instances),
            longest_handle: tables.longest_handle(),
            batch: Vec::with_capacity(sizes.states),
            frames: Vec::with_capacity(buffers.common.frames.len()),
            handles: Vec::with_capacity(buffers.common.handles.len()),
            past_frames: Vec::with_capacity(buffers.common.past_frames.len()),
            past_handles: Vec::with_capacity(buffers.common.past_handles.len()),
            colliders: Vec::with_capacity(options.colliders),
            features: Vec::with_capacity(buffers.common.pose_features.len()),
            prescribed: Vec::with_capacity(buffers.common.prescribed.len()),
            bases: Vec::with_capacity(sizes.states),
            base_of: Vec::with_capacity(sizes.states),
            beyond: Vec::with_capacity(sizes.states),
            pattern: tables.pattern,
            checks: Checks::new(&avatar, instances),
            has_friction: false,
            selects: false,
            has_prescribed: false,
            queue: queue.clone(),
            avatar,
            options,
            buffers,
        })
    }

    /// Bytes that one question of it reads back at most: the room that a [`Submission`] needs for it.
    pub fn room_to_read(&self) -> u64 {
        self.buffers.sizes.room_to_read()
    }

    /// Bytes of `instance`'s posed skin among all instances'.
    pub(super) fn skin_range(&self, instance: usize) -> Range<u64> {
        let bytes = |vertices: usize| vertices as u64 * size_of::<SkinVertex>() as u64;
        let first = bytes(instance * self.buffers.sizes.skin_stride);
        first..first + bytes(self.avatar.skin.len())
    }

    pub(super) fn patience(&self) -> Patience {
        Patience {
            waiting: self.options.waiting,
            timeout: self.options.timeout,
        }
    }

    pub(super) fn start(&self, instance: usize) -> Result<&Start> {
        (self.starts.get(instance))
            .and_then(Option::as_ref)
            .ok_or_else(|| {
                Error::invalid(
                    "instance",
                    format!("{instance} has not begun a step; call begin_step first"),
                )
            })
    }

    /// Before the starts' part of the uploads is written: what waits for its last contents is sent.
    pub(super) fn claim_starts(&mut self, submission: &mut Submission) {
        claim(&mut self.starts_recording, submission);
    }

    /// Before the states' part of the uploads is written: what waits for its last contents is sent.
    pub(super) fn claim_states(&mut self, submission: &mut Submission) {
        claim(&mut self.states_recording, submission);
    }

    /// Before the part of the uploads is written that is posed: what waits for its last contents is sent.
    pub(super) fn claim_poses(&mut self, submission: &mut Submission) {
        claim(&mut self.poses_recording, submission);
    }

    /// Sends the offsets of instances whose others the device has; x̄ of their posed skins is then that of the past.
    pub(super) fn upload_offsets<'a>(
        &mut self,
        offsets: impl Iterator<Item = (usize, &'a [[f32; 3]])> + Clone,
        submission: &mut Submission,
    ) {
        if (offsets.clone()).any(|(i, offsets)| self.offsets[i] != *offsets) {
            claim(&mut self.offsets_recording, submission);
        }
        self.offsets_recording = submission.recording();
        let vertices = self.buffers.sizes.offset_vertices;
        for (i, offsets) in offsets {
            let held = &mut self.offsets[i];
            if held != offsets {
                held.clear();
                held.extend_from_slice(offsets);
                self.posed_features[i].clear();
                (self.buffers.common.pose_offsets).write(&self.queue, i * vertices, offsets);
            }
        }
    }

    /// Records dispatches.
    pub(super) fn dispatch(
        &self,
        submission: &mut Submission,
        record: impl FnOnce(&Stages, &mut wgpu::ComputePass<'_>),
    ) {
        let encoder = submission.encoder();
        let mut pass = encoder.begin_compute_pass(&Default::default());
        record(&self.stages, &mut pass);
    }

    /// The dispatches that `states` states take, those with scratch memory in chunks.
    pub(super) fn chunks(&self, states: usize) -> impl Iterator<Item = Batch> + use<> {
        let size = self.buffers.sizes.chunk_size;
        (0..states.div_ceil(size)).map(move |chunk| Batch {
            chunk: chunk as u32,
            states: size.min(states - chunk * size) as u32,
        })
    }

    /// Its own results among all `bytes` that were read back.
    pub(super) fn own<'a>(&self, bytes: &'a [u8]) -> Result<&'a [u8]> {
        part(bytes, &self.results)
    }
}

/// A `range` of all `bytes` that were read back.
pub(super) fn part<'a>(bytes: &'a [u8], range: &Range<usize>) -> Result<&'a [u8]> {
    let problem = "are not those of the submission that it was recorded into";
    (bytes.get(range.clone())).ok_or_else(|| Error::invalid("bytes", problem))
}

/// What the host writes takes effect before the whole recording that is open: `region` is written once in each.
fn claim(region: &mut u64, submission: &mut Submission) {
    if *region == submission.recording() {
        submission.submit();
    }
    *region = submission.recording();
}
