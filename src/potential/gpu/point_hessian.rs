//! The Hessian of every cubature point by itself.

use super::buffers::Buffers;
use super::{Batch, Sources};
use crate::Result;
use crate::gpu::Kernel;

pub(super) const INCLUDES: &[&str] = &[
    "shared/batch.wgsl",
    "shared/kinematics.wgsl",
    "shared/tensor.wgsl",
    "point_hessian.wgsl",
];

/// All pairs of blocks of every point.
#[derive(Debug)]
pub(super) struct PointHessian {
    point_hessian: Kernel,
    points: u32,
}

impl PointHessian {
    pub fn new(device: &wgpu::Device, sources: &Sources, buffers: &Buffers) -> Result<Self> {
        let module = sources.module("point_hessian", INCLUDES)?;
        Ok(Self {
            point_hessian: module.kernel(device, "point_hessian", &buffers.over_cubature())?,
            points: buffers.cubature.points.len() as u32,
        })
    }

    pub fn dispatch(&self, pass: &mut wgpu::ComputePass<'_>, batch: Batch) {
        batch.dispatch(&self.point_hessian, pass, self.points);
    }
}
