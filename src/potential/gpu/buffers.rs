//! Every buffer of a potential, made once, under the names that the kernels use.

use super::grids::Grids;
use super::shared::{
    BatchState, Collider, Constants, Contact, Frame, Handle, HandleGradient, Influence, Lagged,
    LocalTissue, Mat3, Motion, PartialEnergy, PatternBlock, Point, SkinVertex, Summary, Tangent,
};
use super::tables::{PointTable, Tables};
use super::upload::columns;
use super::{GpuOptions, WORKGROUP};
use crate::gpu::{Bindings, Buffer};
use crate::model::Avatar;
use crate::{GpuError, Result};
use wgpu::BufferUsages;

/// Bytes between two chunks' uniforms: WebGPU's `min_uniform_buffer_offset_alignment`.
pub(super) const CHUNK_STRIDE: u64 = 256;

/// Rows that `contacts` active contacts may have: a push each, and two of friction.
pub(super) fn row_room(contacts: usize) -> usize {
    3 * contacts
}

/// How many of what.
#[derive(Clone, Copy, Debug)]
pub(super) struct Capacity {
    /// States that one submission takes besides the starts.
    pub states: usize,
    /// States that one dispatch takes where scratch memory is needed.
    pub lanes: usize,
}

/// A set of points on the device.
#[derive(Debug)]
pub(super) struct PointBuffers {
    pub constants: Buffer<Constants>,
    pub points: Buffer<Point>,
    pub influences: Buffer<Influence>,
    pub columns: Buffer<f32>,
    /// x̄ of every instance.
    pub unposed: Buffer<[f32; 4]>,
}

#[derive(Debug)]
pub(super) struct Buffers {
    pub capacity: Capacity,
    /// Numbers of gradient and Hessian of one state.
    pub result_stride: usize,
    pub cubature: PointBuffers,
    pub skin: PointBuffers,
    /// x̄ of the drawn skin.
    pub posed_skin_unposed: Buffer<[f32; 4]>,
    pub chunks: Buffer<[u32; 64]>,
    pub tissue: Buffer<LocalTissue>,
    pub gradients: Buffer<HandleGradient>,
    pub gather_rows: Buffer<u32>,
    pub gather_entries: Buffer<u32>,
    pub pattern: Buffer<PatternBlock>,
    pub gather_pairs: Buffer<u32>,
    pub vertex_blocks: Buffer<u32>,
    pub one_ring_rows: Buffer<u32>,
    pub one_ring_edges: Buffer<[u32; 2]>,
    // Written by the host.
    pub batch: Buffer<BatchState>,
    pub features: Buffer<f32>,
    pub frames: Buffer<Frame>,
    pub handles: Buffer<Handle>,
    pub colliders: Buffer<Collider>,
    pub previous_colliders: Buffer<Collider>,
    pub grids: Grids,
    // By slot.
    pub motion: Buffer<Motion>,
    pub stress: Buffer<Mat3>,
    pub tangent: Buffer<Tangent>,
    pub distances: Buffer<[f32; 4]>,
    pub slips: Buffer<[f32; 4]>,
    // By instance.
    pub lagged_distances: Buffer<[f32; 4]>,
    pub lagged: Buffer<Lagged>,
    // By lane.
    pub point_gradients: Buffer<[f32; 4]>,
    pub point_hessians: Buffer<Mat3>,
    pub contacts: Buffer<Contact>,
    pub contact_rows: Buffer<[f32; 4]>,
    pub block_contacts: Buffer<u32>,
    // By state of the batch.
    pub partial_energies: Buffer<PartialEnergy>,
    pub summaries: Buffer<Summary>,
    pub result: Buffer<f32>,
    /// Positions and normals of every instance's drawn skin.
    pub skin_vertices: Buffer<SkinVertex>,
}

impl Buffers {
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        avatar: &Avatar,
        tables: &Tables,
        instances: usize,
        options: &GpuOptions,
    ) -> Result<Self> {
        let (cubature, skin) = (&tables.cubature, &tables.skin);
        let (points, vertices) = (cubature.points.len(), skin.points.len());
        let space = avatar.space();
        let result_stride = space.dofs() + 9 * tables.pattern.len();
        let rows = row_room(options.contacts);
        // A vertex's own and a body's.
        let contact_blocks = skin.blocks.longest() + 2;
        // The largest scratch buffers of one state decide how many go at once.
        let scratch = [
            48 * cubature.pairs,
            4 * space.blocks() * (rows + 1),
            16 * rows * contact_blocks,
        ];
        let scratch = scratch.into_iter().max().unwrap_or(1).max(1) as u64;
        let limits = device.limits();
        let room = options
            .scratch_bytes
            .min(limits.max_storage_buffer_binding_size)
            .min(limits.max_buffer_size);
        let capacity = Capacity {
            states: instances.max(2 * options.trials.max(1)),
            lanes: instances.min((room / scratch) as usize).max(1),
        };
        let Capacity { states, lanes, .. } = capacity;
        let slots = instances + states;
        check_dispatch(device, "cubature points", points)?;
        let hessian_groups = tables.pattern.len().div_ceil(WORKGROUP as usize);
        check_dispatch(device, "workgroups of the Hessian", hessian_groups)?;
        check_dispatch(device, "states in a submission", states)?;

        let constants = Constants {
            points: points as u32,
            bones: space.frames as u32,
            handles: space.handles as u32,
            features: avatar.cubature.pose_blend.features as u32,
            blocks: space.blocks() as u32,
            pattern_blocks: tables.pattern.len() as u32,
            local_blocks: cubature.blocks.entries().len() as u32,
            local_pairs: cubature.pairs as u32,
            colliders: options.colliders as u32,
            contacts: options.contacts as u32,
            contact_blocks: contact_blocks as u32,
            point_groups: (points as u32).div_ceil(WORKGROUP),
            vertex_groups: (vertices as u32).div_ceil(WORKGROUP),
            density: avatar.density as f32,
            material: material_parameters(avatar),
            ..Constants::default()
        };
        let skin_constants = Constants {
            points: vertices as u32,
            features: avatar.skin.pose_blend.features as u32,
            ..constants
        };
        let storage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let point_buffers = |table: &PointTable, constants: Constants, label: &str| {
            let uniform = Buffer::new(device, "constants", 1, BufferUsages::UNIFORM)?;
            uniform.write(queue, 0, &[constants]);
            let unposed = instances * table.points.len();
            Ok::<_, crate::Error>(PointBuffers {
                constants: uniform,
                points: Buffer::holding(device, queue, label, &table.points)?,
                influences: Buffer::holding(device, queue, "influences", &table.influences)?,
                columns: Buffer::holding(device, queue, "pose_columns", &table.columns)?,
                unposed: Buffer::new(device, "unposed", unposed, storage)?,
            })
        };
        let chunk_count = states.div_ceil(lanes);
        let chunks = Buffer::new(device, "chunks", chunk_count, BufferUsages::UNIFORM)?;
        for chunk in 0..chunk_count {
            let mut words = [0; 64];
            words[0] = (chunk * lanes) as u32;
            chunks.write(queue, chunk, &[words]);
        }
        let partials = (constants.point_groups + constants.vertex_groups) as usize;
        let features = constants.features.max(skin_constants.features) as usize;
        macro_rules! zeroed {
            ($label:literal, $len:expr) => {
                Buffer::new(device, $label, $len, storage)?
            };
        }
        macro_rules! holding {
            ($label:literal, $items:expr) => {
                Buffer::holding(device, queue, $label, $items)?
            };
        }
        Ok(Self {
            capacity,
            result_stride,
            cubature: point_buffers(cubature, constants, "cubature points")?,
            skin: point_buffers(skin, skin_constants, "skin points")?,
            posed_skin_unposed: zeroed!("posed_skin_unposed", instances * vertices),
            chunks,
            tissue: holding!("tissue", &local_tissue(avatar)),
            gradients: holding!("handle_gradients", &cubature.gradients),
            gather_rows: holding!("gather_rows", tables.gather.offsets()),
            gather_entries: holding!("gather_entries", tables.gather.entries()),
            pattern: holding!("pattern", &tables.pattern_blocks),
            gather_pairs: holding!("gather_pairs", &tables.gather_pairs),
            vertex_blocks: holding!("vertex_blocks", &tables.vertex_blocks),
            one_ring_rows: holding!("one_ring_rows", tables.one_ring.offsets()),
            one_ring_edges: holding!("one_ring_edges", tables.one_ring.entries()),
            batch: zeroed!("batch", states),
            features: zeroed!("pose_features", states * features),
            frames: zeroed!("frames", slots * space.frames),
            handles: zeroed!("handles", slots * space.handles),
            grids: Grids::new(device, options.meshes)?,
            colliders: zeroed!("colliders", instances * options.colliders),
            previous_colliders: zeroed!("previous_colliders", instances * options.colliders),
            motion: zeroed!("motion", slots * points),
            stress: zeroed!("stress", 2 * instances * points),
            tangent: zeroed!("tangent", 2 * instances * points),
            distances: zeroed!("distances", slots * vertices * options.colliders),
            slips: zeroed!("slips", slots * options.contacts),
            lagged_distances: zeroed!("lagged_distances", instances * vertices * options.colliders),
            lagged: zeroed!("lagged", instances * (options.contacts + 1)),
            point_gradients: zeroed!("point_gradients", lanes * cubature.blocks.entries().len()),
            point_hessians: zeroed!("point_hessians", lanes * cubature.pairs),
            contacts: zeroed!("contacts", states.max(lanes) * (rows + 1)),
            contact_rows: zeroed!("contact_rows", lanes * rows * contact_blocks),
            block_contacts: zeroed!("block_contacts", lanes * space.blocks() * (rows + 1)),
            partial_energies: zeroed!("partial_energies", states * partials),
            summaries: zeroed!("summaries", states),
            result: zeroed!("result", instances * result_stride),
            skin_vertices: Buffer::new(
                device,
                "skin_vertices",
                instances * vertices,
                storage | BufferUsages::VERTEX,
            )?,
        })
    }

    /// The buffer that kernels over the cubature, else over the skin, call `name`; `skin_unposed` and
    /// `posed_skin_unposed` are the x̄ of the skin.
    pub fn intermediate(&self, name: &str) -> Option<&wgpu::Buffer> {
        match name {
            "unposed" => Some(self.cubature.unposed.raw()),
            "skin_unposed" => Some(self.skin.unposed.raw()),
            "posed_skin_unposed" => Some(self.posed_skin_unposed.raw()),
            "pose_features" => Some(self.features.raw()),
            "frames" => Some(self.frames.raw()),
            "handles" => Some(self.handles.raw()),
            "colliders" => Some(self.colliders.raw()),
            "motion" => Some(self.motion.raw()),
            "stress" => Some(self.stress.raw()),
            "tangent" => Some(self.tangent.raw()),
            "distances" => Some(self.distances.raw()),
            "previous_colliders" => Some(self.previous_colliders.raw()),
            "lagged_distances" => Some(self.lagged_distances.raw()),
            "lagged" => Some(self.lagged.raw()),
            "slips" => Some(self.slips.raw()),
            "contacts" => Some(self.contacts.raw()),
            "block_contacts" => Some(self.block_contacts.raw()),
            "contact_rows" => Some(self.contact_rows.raw()),
            "point_gradients" => Some(self.point_gradients.raw()),
            "point_hessians" => Some(self.point_hessians.raw()),
            "summaries" => Some(self.summaries.raw()),
            "skin_vertices" => Some(self.skin_vertices.raw()),
            _ => None,
        }
    }

    fn common(&self) -> Bindings<'_> {
        Bindings::default()
            .with_dynamic("chunk", self.chunks.raw(), CHUNK_STRIDE)
            .with("batch", self.batch.raw())
            .with("pose_features", self.features.raw())
            .with("tissue", self.tissue.raw())
            .with("handle_gradients", self.gradients.raw())
            .with("gather_rows", self.gather_rows.raw())
            .with("gather_entries", self.gather_entries.raw())
            .with("pattern", self.pattern.raw())
            .with("gather_pairs", self.gather_pairs.raw())
            .with("vertex_blocks", self.vertex_blocks.raw())
            .with("one_ring_rows", self.one_ring_rows.raw())
            .with("one_ring_edges", self.one_ring_edges.raw())
            .with("frames", self.frames.raw())
            .with("handles", self.handles.raw())
            .with("colliders", self.colliders.raw())
            .with_texture("distance_grids", self.grids.view())
            .with("motion", self.motion.raw())
            .with("stress", self.stress.raw())
            .with("tangent", self.tangent.raw())
            .with("distances", self.distances.raw())
            .with("point_gradients", self.point_gradients.raw())
            .with("point_hessians", self.point_hessians.raw())
            .with("lagged", self.lagged.raw())
            .with("slips", self.slips.raw())
            .with("contacts", self.contacts.raw())
            .with("contact_rows", self.contact_rows.raw())
            .with("block_contacts", self.block_contacts.raw())
            .with("partial_energies", self.partial_energies.raw())
            .with("summaries", self.summaries.raw())
            .with("result", self.result.raw())
            .with("skin_vertices", self.skin_vertices.raw())
    }

    fn with_points<'a>(&'a self, set: &'a PointBuffers) -> Bindings<'a> {
        self.common()
            .with("constants", set.constants.raw())
            .with("points", set.points.raw())
            .with("influences", set.influences.raw())
            .with("pose_columns", set.columns.raw())
            .with("unposed", set.unposed.raw())
    }

    /// For kernels over the cubature points.
    pub fn over_cubature(&self) -> Bindings<'_> {
        self.with_points(&self.cubature)
    }

    /// For kernels over the skin that touches.
    pub fn over_skin(&self) -> Bindings<'_> {
        self.with_points(&self.skin)
    }

    /// For kernels over the skin at a step's start, against the colliders of tⁿ.
    pub fn over_lagged_skin(&self) -> Bindings<'_> {
        self.over_skin()
            .with("colliders", self.previous_colliders.raw())
            .with("distances", self.lagged_distances.raw())
    }

    /// For kernels over the skin that is drawn, whose x̄ follows its own pose.
    pub fn over_drawn_skin(&self) -> Bindings<'_> {
        self.over_skin()
            .with("unposed", self.posed_skin_unposed.raw())
    }
}

fn material_parameters(avatar: &Avatar) -> [[f32; 4]; 3] {
    let p = avatar.material.parameters().map(|p| p as f32);
    std::array::from_fn(|row| std::array::from_fn(|column| p[4 * row + column]))
}

fn local_tissue(avatar: &Avatar) -> Vec<LocalTissue> {
    let local = |i: usize| {
        let local = avatar.tissue_at(i).local;
        LocalTissue {
            axes: columns(glam::DMat3::from_quat(local.axes)),
            stiffness: local.stiffness as f32,
            ..LocalTissue::default()
        }
    };
    (0..avatar.cubature.len()).map(local).collect()
}

fn check_dispatch(device: &wgpu::Device, what: &str, needed: usize) -> Result<()> {
    let limit = u64::from(device.limits().max_compute_workgroups_per_dimension);
    if needed as u64 > limit {
        return Err(GpuError::Limit {
            what: what.to_owned(),
            needed: needed as u64,
            limit,
            cure: "use a smaller avatar or evaluate on the CPU",
        }
        .into());
    }
    Ok(())
}
