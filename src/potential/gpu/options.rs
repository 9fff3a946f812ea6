//! What a host chooses.

use crate::gpu::Waiting;
use std::time::Duration;

/// What a [`GpuPotential`](super::GpuPotential) makes room for.
#[derive(Clone, Debug)]
pub struct GpuOptions {
    /// Colliders an instance may have.
    pub colliders: usize,
    /// Different meshes that colliders may be of, in all instances; 432 KiB each.
    pub meshes: usize,
    /// Active contacts an instance may have; of more, the deepest at a step's start are kept through the step.
    pub contacts: usize,
    /// Trials of a line search that go in one submission; more take several.
    pub trials: usize,
    /// Bytes that a scratch buffer may have; states that do not fit go through it in turns.
    pub scratch_bytes: u64,
    /// Who drives the device while a readback is awaited.
    pub waiting: Waiting,
    /// How long a readback that blocks its thread ([`Waiting::Block`]) is awaited at most, before it is a
    /// [`GpuError::Timeout`](crate::GpuError::Timeout); the first answer ten times as long, since some drivers compile
    /// kernels when they first run.
    pub timeout: Duration,
}

impl Default for GpuOptions {
    fn default() -> Self {
        Self {
            colliders: 8,
            meshes: 1,
            contacts: 2048,
            trials: 8,
            scratch_bytes: 128 << 20,
            waiting: Waiting::default(),
            timeout: Duration::from_secs(10),
        }
    }
}
