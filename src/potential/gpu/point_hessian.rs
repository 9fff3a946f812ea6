//! The Hessian of every cubature point by itself.

use super::buffers::Buffers;
use super::dispatch::Batch;
use super::stage::{Stage, StagePipelines};
use crate::Result;
use crate::gpu::Kernel;

/// All pairs of blocks of every point.
#[derive(Debug)]
pub(super) struct PointHessian {
    point_hessian: Kernel,
    points: u32,
}

impl Stage for PointHessian {
    const INCLUDES: &'static [&'static str] = &[
        "shared/batch.wgsl",
        "shared/kinematics.wgsl",
        "shared/tensor.wgsl",
    ];

    fn new(pipelines: &StagePipelines, buffers: &Buffers) -> Result<Self> {
        Ok(Self {
            point_hessian: pipelines.kernel("point_hessian", &buffers.over_cubature())?,
            points: buffers.sizes.points as u32,
        })
    }

    fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.point_hessian, pass, self.points);
    }
}
