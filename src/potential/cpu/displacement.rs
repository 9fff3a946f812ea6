//! Displacement of a point between two states, from increments only:
//!
//! ```text
//! d = Σ_j w_j ( ΔR_j (T_base − J_j) + R_j ΔT + Δc_j )
//! T_base = x̄ + Σ_h N_h φ_base,h    ΔT = Σ_h N_h Δφ_h    ΔR = R − R_base    Δc = c − c_base
//! ```
//!
//! World positions are never subtracted from each other.

use super::Basis;
use crate::model::{Frame, SkinWeight};
use glam::{DMat3, DVec3};

/// How a frame moves from a base state to a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameMotion {
    /// R, in the state.
    pub rotation: DMat3,
    /// ΔR = R − R_base.
    pub rotation_change: DMat3,
    /// Δc = c − c_base, m.
    pub translation_change: DVec3,
}

impl FrameMotion {
    /// From `base` to `state`, both relative to one origin.
    pub fn new(base: &Frame, state: &Frame) -> Self {
        Self {
            rotation: state.rotation,
            rotation_change: state.rotation - base.rotation,
            translation_change: state.position - base.position,
        }
    }
}

/// Σ_h N_h φ_h, m.
pub fn unposed_displacement<B: Basis>(basis: &[B], handles: &[DVec3]) -> DVec3 {
    basis
        .iter()
        .map(|n| n.displacement(handles[n.handle()]))
        .sum()
}

/// d, m, of a point at `base` (T_base) that moves by `change` (ΔT) in unposed space.
pub fn displacement(
    skinning: &[SkinWeight],
    joints: &[DVec3],
    motions: &[FrameMotion],
    base: DVec3,
    change: DVec3,
) -> DVec3 {
    skinning
        .iter()
        .map(|w| {
            let j = w.bone as usize;
            let motion = &motions[j];
            w.weight
                * (motion.rotation_change * (base - joints[j])
                    + motion.rotation * change
                    + motion.translation_change)
        })
        .sum()
}

/// x = Σ_j w_j (R_j (T − J_j) + c_j), m, relative to the frames' origin.
pub fn position(
    skinning: &[SkinWeight],
    joints: &[DVec3],
    frames: &[Frame],
    unposed: DVec3,
) -> DVec3 {
    skinning
        .iter()
        .map(|w| {
            let j = w.bone as usize;
            w.weight * frames[j].transform(unposed - joints[j])
        })
        .sum()
}

/// B = Σ_j w_j R_j.
pub fn blended_rotation(skinning: &[SkinWeight], frames: &[Frame]) -> DMat3 {
    skinning
        .iter()
        .map(|w| frames[w.bone as usize].rotation * w.weight)
        .sum()
}

/// a_j = w_j R_j (T − J_j), m, of each bone of the point: ∂x/∂ω_j = −\[a_j\]×.
pub fn arms(
    skinning: &[SkinWeight],
    joints: &[DVec3],
    frames: &[Frame],
    unposed: DVec3,
    out: &mut [DVec3],
) {
    for (arm, w) in out.iter_mut().zip(skinning) {
        let j = w.bone as usize;
        *arm = w.weight * (frames[j].rotation * (unposed - joints[j]));
    }
}
