//! What this workspace's own crates and tests use besides the public engine; nothing here is stable.

/// Small dense algebra, compressed rows, threads, seeded numbers.
pub mod math {
    pub use crate::math::*;
}

/// The f64 evaluation, stage by stage.
pub mod cpu {
    pub use crate::potential::cpu::*;
}

/// The host side of the kernels.
#[cfg(feature = "gpu")]
pub mod gpu {
    pub use crate::potential::gpu::*;
}

/// Each of the bones' own terms.
pub mod skeleton {
    pub use crate::skeleton::bending::BendingSpring;
    pub use crate::skeleton::bone_inertia::BoneInertia;
    pub use crate::skeleton::gravity::{FrameGravity, TissueMoments};
    pub use crate::skeleton::joint::{JointSpring, joint_gap};
    pub use crate::skeleton::limit::LimitSpring;
    pub use crate::skeleton::log_derivative::{inverse_left_jacobian, log_curvature};
    pub use crate::skeleton::preload::{Held, PreloadedBone};
    pub use crate::skeleton::system::{SkeletonModel, SkeletonStart};
    pub use crate::skeleton::term::{FrameHessian, FrameTerm, Residual, rotation_curvature};
    pub use crate::skeleton::tracking::TrackingSpring;
}

/// Kernels, buffers and submissions.
#[cfg(feature = "gpu")]
pub mod gpu_plumbing {
    pub use crate::gpu::buffer::Buffer;
    pub use crate::gpu::buffer_list::Allocator;
    pub use crate::gpu::kernel::{Bindings, Kernel};
    pub use crate::gpu::layout::{HostShareable, SharedValue, StructLayout};
    pub use crate::gpu::module::Module;
    pub use crate::gpu::pipeline::{Pipeline, Shader};
    pub use crate::gpu::readback::{Bytes, Patience};
    pub use crate::gpu::submission::Submission;
}

/// Pose features of blend shapes, and the blocks of a point.
pub mod features {
    pub use crate::model::skeleton::{pose_feature, pose_feature_into, pose_features};
    pub use crate::potential::pattern::point_blocks;
}

/// What reduced and sparse solvers share.
pub mod linear_solver {
    pub use crate::sim::linear_solver::*;
}

pub use crate::file::whole::write_whole;
pub use crate::random_avatar::{pose_offsets, random_avatar, random_state};
