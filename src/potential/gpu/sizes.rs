//! How many of what there are, and how many there is room for.

use super::dispatch::{Batch, CHUNK_STRIDE, workgroups};
use super::options::GpuOptions;
use super::shared::{Constants, Contact, SkinVertex, Summary};
use super::tables::Tables;
use crate::model::Avatar;
use crate::{GpuError, Result};

/// An instance's posed skin begins at a multiple of this, bytes: WebGPU's `min_storage_buffer_offset_alignment`, so that a
/// host may bind it alone.
const SKIN_ALIGNMENT: usize = 256;

/// Rows that `contacts` active contacts may have: one along the normal each, and two of friction.
fn row_room(contacts: usize) -> usize {
    3 * contacts
}

/// The numbers that buffers and dispatches are sized by.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sizes {
    pub instances: usize,
    /// States that one submission takes besides the starts, which come behind them in a batch.
    pub states: usize,
    /// States that one dispatch takes where scratch memory is needed.
    pub chunk_size: usize,
    /// Places for what is computed of a state: first every instance's start, then the states.
    pub slots: usize,
    /// Places for a state: the slots, then every instance's state that is posed.
    pub uploads: usize,
    /// Cubature points.
    pub points: usize,
    /// Vertices of the skin.
    pub vertices: usize,
    /// From an instance's posed skin to the next one's, vertices.
    pub skin_stride: usize,
    pub bones: usize,
    pub handles: usize,
    /// Pose features, the most of any set of points.
    pub features: usize,
    /// Skin vertices that may have offsets; none where the tissue could not follow them.
    pub offset_vertices: usize,
    /// 3-vectors of q.
    pub blocks: usize,
    /// Stored blocks of the Hessian.
    pub pattern_blocks: usize,
    /// Threads that gather them.
    pub hessian_segments: usize,
    /// Words of a bit for each bone.
    pub frame_words: usize,
    /// Σ of the blocks of every cubature point.
    pub local_blocks: usize,
    /// Σ of the pairs of blocks of every cubature point.
    pub local_pairs: usize,
    /// Room for colliders, an instance.
    pub colliders: usize,
    /// Room for active contacts, a state.
    pub contacts: usize,
    /// Room for the rows of the contacts, a state.
    pub rows: usize,
    /// Most blocks that a contact moves: a vertex's own and a body's.
    pub contact_blocks: usize,
    /// Sums of energies, a state: one a workgroup.
    pub partial_energies: usize,
    /// Numbers of gradient and Hessian, a state.
    pub result: usize,
}

impl Sizes {
    /// For `instances` avatars on a device of these `limits`.
    pub fn new(
        limits: &wgpu::Limits,
        avatar: &Avatar,
        tables: &Tables,
        instances: usize,
        options: &GpuOptions,
    ) -> Self {
        let (cubature, skin) = (&tables.cubature, &tables.skin);
        let (points, vertices) = (cubature.points.len(), skin.points.len());
        let space = avatar.space();
        let rows = row_room(options.contacts);
        let contact_blocks = skin.blocks.longest() + 2;
        // The largest scratch buffers of one state decide how many go at once.
        let scratch = [
            48 * cubature.pairs,
            size_of::<Contact>() * (rows + 1),
            4 * space.blocks() * (rows + 1),
            16 * rows * contact_blocks,
        ];
        let scratch = scratch.into_iter().max().unwrap_or(1).max(1) as u64;
        let room = options.scratch_bytes.min(buffer_limit(limits));
        let states = instances.max(options.trials.max(1).saturating_mul(2));
        Self {
            instances,
            states,
            chunk_size: instances.min((room / scratch) as usize).max(1),
            slots: instances.saturating_add(states),
            uploads: states.saturating_add(instances.saturating_mul(2)),
            points,
            vertices,
            skin_stride: vertices.next_multiple_of(SKIN_ALIGNMENT / size_of::<SkinVertex>()),
            bones: space.frames,
            handles: space.handles,
            features: (avatar.cubature.pose_blend.features).max(avatar.skin.pose_blend.features),
            offset_vertices: skin.shares(),
            blocks: space.blocks(),
            pattern_blocks: tables.pattern.len(),
            hessian_segments: tables.hessian_segments.len(),
            frame_words: space.frames.div_ceil(32),
            local_blocks: cubature.blocks.entries().len(),
            local_pairs: cubature.pairs,
            colliders: options.colliders,
            contacts: options.contacts,
            rows,
            contact_blocks,
            partial_energies: (workgroups(points) + workgroups(vertices)) as usize,
            result: space.dofs() + 9 * tables.pattern.len(),
        }
    }

    /// # Errors
    /// [`GpuError::Limit`] where the device dispatches no kernel so large.
    pub fn check_dispatches(&self, limits: &wgpu::Limits) -> Result<()> {
        let limit = u64::from(limits.max_compute_workgroups_per_dimension);
        let hessian_groups = workgroups(self.hessian_segments) as usize;
        for (what, needed) in [
            ("cubature points", self.points),
            ("workgroups of the Hessian", hessian_groups),
            ("states in a submission", self.states),
        ] {
            if needed as u64 > limit {
                return Err(GpuError::Limit {
                    what: what.to_owned(),
                    needed: needed as u64,
                    limit,
                    cure: "use fewer instances or a smaller avatar, or evaluate on the CPU",
                }
                .into());
            }
        }
        Ok(())
    }

    /// The starts of a step, of which there are `count`: their places are behind those of the states.
    pub fn starts(&self, count: usize) -> Batch {
        Batch {
            chunk: self.states.div_ceil(self.chunk_size) as u32,
            states: count as u32,
        }
    }

    /// Every instance's state that is posed: their places are behind those of the starts.
    pub fn poses(&self) -> Batch {
        Batch {
            chunk: self.states.div_ceil(self.chunk_size) as u32 + 1,
            states: self.instances as u32,
        }
    }

    /// Bytes that one question reads back at most, and the end of the step before with it.
    pub fn room_to_read(&self) -> u64 {
        let results = 4 * self.result + self.contact_bytes();
        let question = self.states * size_of::<Summary>() + self.instances * results;
        let end = self.instances * (size_of::<Summary>() + self.frame_gradient_bytes());
        (question + end) as u64
    }

    /// Bytes of a state's gradient by frames.
    pub fn frame_gradient_bytes(&self) -> usize {
        4 * 6 * self.bones
    }

    /// What kernels over the cubature points know.
    pub fn constants(&self, avatar: &Avatar) -> Constants {
        Constants {
            points: self.points as u32,
            bones: self.bones as u32,
            handles: self.handles as u32,
            features: avatar.cubature.pose_blend.features as u32,
            blocks: self.blocks as u32,
            pattern_blocks: self.pattern_blocks as u32,
            local_blocks: self.local_blocks as u32,
            local_pairs: self.local_pairs as u32,
            colliders: self.colliders as u32,
            contacts: self.contacts as u32,
            contact_blocks: self.contact_blocks as u32,
            point_groups: workgroups(self.points),
            vertex_groups: workgroups(self.vertices),
            density: avatar.density as f32,
            skin_stride: self.skin_stride as u32,
            offset_vertices: self.offset_vertices as u32,
        }
    }

    /// What kernels over the skin know.
    pub fn skin_constants(&self, avatar: &Avatar) -> Constants {
        Constants {
            points: self.vertices as u32,
            features: avatar.skin.pose_blend.features as u32,
            ..self.constants(avatar)
        }
    }

    /// Bytes of the contacts of one state: a header with the number of rows, then the rows.
    pub fn contact_bytes(&self) -> usize {
        (1 + self.rows) * size_of::<Contact>()
    }

    /// The first state of every chunk, the first start and the first that is posed, padded to [`CHUNK_STRIDE`].
    pub fn chunks(&self) -> Vec<[u32; CHUNK_STRIDE as usize / 4]> {
        let first = (0..self.states).step_by(self.chunk_size);
        let behind = [self.states, self.states + self.instances];
        let padded = first.chain(behind).map(|first| {
            let mut words = [0; CHUNK_STRIDE as usize / 4];
            words[0] = first as u32;
            words
        });
        padded.collect()
    }
}

/// Bytes that a buffer which kernels read may have.
pub(super) fn buffer_limit(limits: &wgpu::Limits) -> u64 {
    (limits.max_storage_buffer_binding_size).min(limits.max_buffer_size)
}
