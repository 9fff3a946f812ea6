//! Every buffer of a potential, made once, under the names that the kernels use. A buffer is a line below.

use super::dispatch::CHUNK_STRIDE;
use super::grids::Grids;
use super::options::GpuOptions;
use super::shared::{
    BatchState, Collider, Constants, Contact, Frame, Handle, HandleGradient, HessianSegment,
    Influence, Lagged, LocalTissue, Mat3, Motion, PartialEnergy, PastFrame, PastHandle, Point,
    SkinVertex, Summary, Tangent,
};
use super::sizes::{Sizes, buffer_limit};
use super::tables::{PointTable, Tables};
use crate::gpu::{Allocator, Bindings, buffers};
use crate::model::Avatar;
use crate::{GpuError, Result};

buffers! {
    /// A set of points: the cubature's, or the skin's vertices.
    pub(super) struct PointBuffers(table: &PointTable, constants: Constants, instances: usize) {
        constants: Constants = uniform(&[constants]),
        points: Point = holding(&table.points),
        influences: Influence = holding(&table.influences),
        pose_columns: f32 = holding(&table.columns),
        /// x̄ of every instance.
        unposed: [f32; 4] = zeroed(instances * table.points.len()),
    }
}

buffers! {
    /// What the kernels over both sets of points share.
    pub(super) struct CommonBuffers(tables: &Tables, n: &Sizes) {
        /// Of which a dispatch binds one item.
        chunk: [u32; CHUNK_STRIDE as usize / 4] = uniform(&n.chunks()),
        // Of the avatar.
        material: u8 = uniform(&tables.material),
        tissue: LocalTissue = holding(&tables.tissue),
        handle_gradients: HandleGradient = holding(&tables.cubature.gradients),
        gather_rows: u32 = holding(tables.gather.offsets()),
        gather_entries: u32 = holding(tables.gather.entries()),
        hessian_segments: HessianSegment = holding(&tables.hessian_segments),
        gather_pairs: u32 = holding(&tables.gather_pairs),
        vertex_blocks: u32 = holding(&tables.vertex_blocks),
        one_ring_rows: u32 = holding(tables.one_ring.offsets()),
        one_ring_edges: [u32; 2] = holding(tables.one_ring.entries()),
        // Written by the host.
        batch: BatchState = zeroed(n.uploads),
        pose_features: f32 = zeroed(n.uploads * n.features),
        /// Of every instance.
        pose_offsets: [f32; 3] = zeroed(n.instances * n.offset_vertices),
        /// A bit for each frame, of the states: starts have no derivatives.
        prescribed: u32 = zeroed(n.states * n.frame_words),
        frames: Frame = zeroed(n.uploads * n.bones),
        handles: Handle = zeroed(n.uploads * n.handles),
        past_frames: PastFrame = zeroed(n.instances * n.bones),
        past_handles: PastHandle = zeroed(n.instances * n.handles),
        colliders: Collider = zeroed(n.instances * n.colliders),
        previous_colliders: Collider = zeroed(n.instances * n.colliders),
        // By slot.
        motion: Motion = zeroed(n.slots * n.points),
        stress: Mat3 = zeroed(2 * n.instances * n.points),
        tangent: Tangent = zeroed(2 * n.instances * n.points),
        distances: [f32; 4] = zeroed(n.slots * n.vertices * n.colliders),
        slips: [f32; 4] = zeroed(n.slots * n.contacts),
        // By instance.
        lagged_distances: [f32; 4] = zeroed(n.instances * n.vertices * n.colliders),
        lagged: Lagged = zeroed(n.instances * (n.contacts + 1)),
        // Scratch memory, by state of the chunk.
        point_gradients: [f32; 4] = zeroed(n.chunk_size * n.local_blocks),
        point_hessians: Mat3 = zeroed(n.chunk_size * n.local_pairs),
        contacts: Contact = zeroed(n.chunk_size * (n.rows + 1)),
        contact_rows: [f32; 4] = zeroed(n.chunk_size * n.rows * n.contact_blocks),
        block_contacts: u32 = zeroed(n.chunk_size * n.blocks * (n.rows + 1)),
        // By state of the batch.
        partial_energies: PartialEnergy = zeroed(n.states * n.partial_energies),
        summaries: Summary = zeroed(n.states),
        result: f32 = zeroed(n.instances * n.result),
        // The posed skin of every instance, that of the step before, and its x̄.
        skin_vertices: SkinVertex = vertices(n.instances * n.skin_stride),
        previous_skin_vertices: SkinVertex = vertices(n.instances * n.skin_stride),
        posed_skin_unposed: [f32; 4] = zeroed(n.instances * n.vertices),
    }
}

/// The largest buffer that kernels read, with its bytes.
fn largest(avatar: &Avatar, tables: &Tables, sizes: &Sizes) -> (u64, &'static str) {
    let n = sizes.instances;
    let cubature = PointBuffers::largest(&tables.cubature, sizes.constants(avatar), n);
    let skin = PointBuffers::largest(&tables.skin, sizes.skin_constants(avatar), n);
    CommonBuffers::largest(tables, sizes)
        .max(cubature)
        .max(skin)
}

/// That `instances` avatars fit on a device of these `limits`.
///
/// # Errors
/// [`GpuError::Limit`] with how many instances do, or, where none does, what is too large.
fn check_room(
    limits: &wgpu::Limits,
    avatar: &Avatar,
    tables: &Tables,
    instances: usize,
    options: &GpuOptions,
) -> Result<()> {
    let fit = |n: usize| {
        let sizes = Sizes::new(limits, avatar, tables, n, options);
        sizes.check_dispatches(limits)?;
        let (needed, name) = largest(avatar, tables, &sizes);
        let (needed, name, limit) = match needed > buffer_limit(limits) {
            true => (needed, name, buffer_limit(limits)),
            false => (sizes.room_to_read(), "readback", limits.max_buffer_size),
        };
        if needed > limit {
            return Err(GpuError::Limit {
                what: format!("bytes in buffer `{name}`"),
                needed,
                limit,
                cure: "use a smaller avatar, or lower GpuOptions::colliders or contacts",
            }
            .into());
        }
        Ok(())
    };
    let Err(error) = fit(instances) else {
        return Ok(());
    };
    let mut most = 0;
    let mut too_many = instances;
    while too_many - most > 1 {
        let middle = most + (too_many - most) / 2;
        match fit(middle) {
            Ok(()) => most = middle,
            Err(_) => too_many = middle,
        }
    }
    if most == 0 {
        return Err(error);
    }
    Err(GpuError::Limit {
        what: "instances of this avatar in one potential".to_owned(),
        needed: instances as u64,
        limit: most as u64,
        cure: "make several potentials, lower GpuOptions::colliders or contacts, or make the device with larger \
               max_storage_buffer_binding_size and max_buffer_size",
    }
    .into())
}

/// All buffers, and the texture of the mesh colliders.
#[derive(Debug)]
pub(super) struct Buffers {
    pub sizes: Sizes,
    pub cubature: PointBuffers,
    pub skin: PointBuffers,
    pub common: CommonBuffers,
    pub grids: Grids,
}

impl Buffers {
    /// # Errors
    /// [`GpuError::Limit`] where the device has no room: of instances, with how many there is room for, or else of what
    /// a single one needs.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        avatar: &Avatar,
        tables: &Tables,
        sizes: Sizes,
        options: &GpuOptions,
    ) -> Result<Self> {
        check_room(&device.limits(), avatar, tables, sizes.instances, options)?;
        let allocator = Allocator { device, queue };
        let of_points =
            |table, constants| PointBuffers::new(allocator, table, constants, sizes.instances);
        Ok(Self {
            cubature: of_points(&tables.cubature, sizes.constants(avatar))?,
            skin: of_points(&tables.skin, sizes.skin_constants(avatar))?,
            common: CommonBuffers::new(allocator, tables, &sizes)?,
            grids: Grids::new(device, options.meshes)?,
            sizes,
        })
    }

    /// The buffer that kernels over the cubature call `name`; `skin_unposed` is the x̄ of the skin that touches.
    pub fn find(&self, name: &str) -> Option<&wgpu::Buffer> {
        let of_points = || match name.strip_prefix("skin_") {
            Some(name) => self.skin.find(name),
            None => self.cubature.find(name),
        };
        self.common.find(name).or_else(of_points)
    }

    fn bindings<'a>(&'a self, set: &'a PointBuffers) -> Bindings<'a> {
        let bindings = set.bound(self.common.bound(Bindings::default()));
        bindings
            .with_dynamic("chunk", self.common.chunk.raw(), CHUNK_STRIDE)
            .with_texture("distance_grids", self.grids.view())
    }

    /// For kernels over the cubature points.
    pub fn over_cubature(&self) -> Bindings<'_> {
        self.bindings(&self.cubature)
    }

    /// For kernels over the skin that touches.
    pub fn over_skin(&self) -> Bindings<'_> {
        self.bindings(&self.skin)
    }

    /// For kernels over the skin at a step's start, against the colliders of tⁿ.
    pub fn over_lagged_skin(&self) -> Bindings<'_> {
        self.over_skin()
            .with("colliders", self.common.previous_colliders.raw())
            .with("distances", self.common.lagged_distances.raw())
    }

    /// For kernels over the posed skin, whose x̄ follows its own pose.
    pub fn over_posed_skin(&self) -> Bindings<'_> {
        self.over_skin()
            .with("unposed", self.common.posed_skin_unposed.raw())
    }
}
