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

/// What reduced and sparse solvers share.
pub mod linear_solver {
    pub use crate::sim::linear_solver::*;
}

pub use crate::random_avatar::{random_avatar, random_state};
