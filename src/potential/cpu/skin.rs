//! The drawn skin: x = Σ_j w_j (R_j (T − J_j) + c_j) with x̄ of the state's own pose.

use super::Basis;
use super::displacement::{position, unposed_displacement};
use crate::model::{Frame, SkinWeight};
use glam::DVec3;

/// Where a vertex with rest place `rest` (x̄) is drawn, m, relative to the frames' origin.
pub fn skin<B: Basis>(
    skinning: &[SkinWeight],
    basis: &[B],
    joints: &[DVec3],
    frames: &[Frame],
    handles: &[DVec3],
    rest: DVec3,
) -> DVec3 {
    let unposed = rest + unposed_displacement(basis, handles);
    position(skinning, joints, frames, unposed)
}
