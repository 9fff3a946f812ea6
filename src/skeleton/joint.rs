//! Springs that hold the two sides of each joint together.

use super::term::{FrameHessian, FrameTerm, Residual, rotation_curvature};
use crate::math::skew;
use crate::model::{Frame, Skeleton};
use glam::{DMat3, DVec3};

/// E = ½ k |r|², r = c_j − c_p − R_p (J_j − J_p).
#[derive(Clone, Copy, Debug)]
pub struct JointSpring {
    /// j.
    pub child: usize,
    /// p.
    pub parent: usize,
    /// J_j − J_p, m.
    pub offset: DVec3,
    /// k, N/m.
    pub stiffness: f64,
}

impl JointSpring {
    /// r, m.
    fn residual(&self, frames: &[Frame]) -> DVec3 {
        let parent = &frames[self.parent];
        frames[self.child].position - parent.position - parent.rotation * self.offset
    }
}

impl FrameTerm for JointSpring {
    fn difference(&self, base: &[Frame], frames: &[Frame]) -> f64 {
        let (r, r0) = (self.residual(frames), self.residual(base));
        0.5 * self.stiffness * (r - r0).dot(r + r0)
    }

    fn add_derivatives(
        &self,
        frames: &[Frame],
        gradient: &mut [f64],
        hessian: &mut FrameHessian<'_>,
    ) {
        let lever = frames[self.parent].rotation * self.offset;
        let residual = Residual {
            jacobian: [
                (2 * self.child, DMat3::IDENTITY),
                (2 * self.parent, -DMat3::IDENTITY),
                (2 * self.parent + 1, skew(lever)),
            ],
        };
        residual.add_gradient(self.stiffness * self.residual(frames), gradient);
        residual.add_hessian(self.stiffness, hessian);
    }

    fn add_geometric(&self, frames: &[Frame], hessian: &mut FrameHessian<'_>) {
        let lever = frames[self.parent].rotation * self.offset;
        let force = self.stiffness * self.residual(frames);
        let rotation = 2 * self.parent + 1;
        hessian.add(rotation, rotation, rotation_curvature(-force, lever));
    }
}

/// Largest |c_j − c_p − R_p (J_j − J_p)| over all joints, m.
pub fn joint_gap(skeleton: &Skeleton, frames: &[Frame]) -> f64 {
    let gap = |(j, parent): (usize, &Option<u32>)| {
        parent.map_or(0.0, |p| {
            let parent = &frames[p as usize];
            let offset = skeleton.joints[j] - skeleton.joints[p as usize];
            (frames[j].position - parent.transform(offset)).length()
        })
    };
    skeleton
        .parents
        .iter()
        .enumerate()
        .map(gap)
        .fold(0.0, f64::max)
}
