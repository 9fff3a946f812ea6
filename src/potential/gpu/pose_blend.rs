//! x̄ = X + Σ_k feature_k column_k at the start of a step, and for the drawn skin.

use super::buffers::Buffers;
use super::{Batch, Sources, WORKGROUP};
use crate::Result;
use crate::gpu::Kernel;

pub(super) const INCLUDES: &[&str] = &[
    "shared/batch.wgsl",
    "shared/kinematics.wgsl",
    "pose_blend.wgsl",
];

/// Pose blend shapes of cubature points, touching skin and drawn skin.
#[derive(Debug)]
pub(super) struct PoseBlend {
    cubature: Kernel,
    skin: Kernel,
    drawn_skin: Kernel,
    point_groups: u32,
    vertex_groups: u32,
}

impl PoseBlend {
    pub fn new(device: &wgpu::Device, sources: &Sources, buffers: &Buffers) -> Result<Self> {
        let module = sources.module("pose_blend", INCLUDES)?;
        let kernel = |bindings| module.kernel(device, "pose_blend", &bindings);
        Ok(Self {
            cubature: kernel(buffers.over_cubature())?,
            skin: kernel(buffers.over_skin())?,
            drawn_skin: kernel(buffers.over_drawn_skin())?,
            point_groups: (buffers.cubature.points.len() as u32).div_ceil(WORKGROUP),
            vertex_groups: (buffers.skin.points.len() as u32).div_ceil(WORKGROUP),
        })
    }

    /// x̄ of the cubature points.
    pub fn dispatch_cubature(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.cubature, pass, self.point_groups);
    }

    /// x̄ of the skin that touches.
    pub fn dispatch_skin(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.skin, pass, self.vertex_groups);
    }

    /// x̄ of what is drawn.
    pub fn dispatch_posed_skin(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.drawn_skin, pass, self.vertex_groups);
    }
}
