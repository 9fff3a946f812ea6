//! x̄ = X + Σ_k feature_k column_k at the start of a step, and for the posed skin.

use super::buffers::Buffers;
use super::dispatch::{Batch, workgroups};
use super::stage::{Run, Stage, StagePipelines};
use crate::Result;
use crate::gpu::Kernel;

/// Pose blend shapes of cubature points, touching skin and posed skin.
#[derive(Debug)]
pub(super) struct PoseBlend {
    cubature: Kernel,
    skin: Kernel,
    posed_skin: Kernel,
    point_groups: u32,
    vertex_groups: u32,
}

impl Stage for PoseBlend {
    const INCLUDES: &'static [&'static str] = &["shared/batch.wgsl", "shared/kinematics.wgsl"];

    fn new(pipelines: &StagePipelines, buffers: &Buffers) -> Result<Self> {
        let kernel = |bindings| pipelines.kernel("pose_blend", &bindings);
        Ok(Self {
            cubature: kernel(buffers.over_cubature())?,
            skin: kernel(buffers.over_skin())?,
            posed_skin: kernel(buffers.over_posed_skin())?,
            point_groups: workgroups(buffers.sizes.points),
            vertex_groups: workgroups(buffers.sizes.vertices),
        })
    }

    /// x̄ of the cubature points.
    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.cubature, pass, self.point_groups);
    }

    fn timed(name: &'static str) -> Vec<(&'static str, Run<Self>)> {
        let posed = ("posed pose_blend", Self::dispatch_posed_skin as Run<Self>);
        vec![(name, Self::dispatch), posed]
    }
}

impl PoseBlend {
    /// x̄ of the skin that touches.
    pub fn dispatch_skin(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.skin, pass, self.vertex_groups);
    }

    /// x̄ of the posed skin.
    pub fn dispatch_posed_skin(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.posed_skin, pass, self.vertex_groups);
    }
}
