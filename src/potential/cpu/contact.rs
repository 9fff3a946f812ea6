//! Penalty contact of skin vertices with colliders: E = ½ k a (d̂ − d)₊².

use super::{Basis, displacement};
use crate::collider::Collider;
use crate::model::{Frame, SkinWeight};
use glam::DVec3;

/// A skin vertex against a collider; untouched where `depth` is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Candidate {
    /// δ = (d̂ − d)₊, m.
    pub depth: f64,
    /// ∇d: outward normal of the collider, in world axes; as long as its shape's.
    pub normal: DVec3,
}

/// One direction in which a contact of a skin vertex with a collider acts. With z the vertex's place
/// seen from the collider, E changes by f (e · δz) + ½ k (e · δz)², so that a contact is one row
/// ℓ = (∂z/∂q)ᵀ e: gradient f ℓ, Hessian k ℓ ℓᵀ. The push along n is a row, friction is two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactRow {
    /// The skin vertex: the side that moves with its bones and handles.
    pub vertex: u32,
    /// The frame that carries the collider: the other side; none where its motion is given.
    pub body: Option<u32>,
    /// e, in world axes: ∇d of a push, a unit vector of friction.
    pub direction: DVec3,
    /// f = ∂E/∂(e · z), N: the vertex is pushed by −f e.
    pub force: f64,
    /// k, N/m, not negative.
    pub stiffness: f64,
}

impl ContactRow {
    /// The push of a contact with k a = `stiffness`: along n with f = −k a δ.
    pub fn normal(candidate: &Candidate, stiffness: f64, vertex: u32, collider: &Collider) -> Self {
        Self {
            vertex,
            body: collider.body,
            direction: candidate.normal,
            force: -(stiffness * candidate.depth),
            stiffness,
        }
    }
}

/// δ and n at `point`, the collider standing at `frame`; both relative to the instance's origin.
pub fn contact(point: DVec3, collider: &Collider, frame: &Frame) -> Candidate {
    let found = collider.signed_distance(frame, point);
    Candidate {
        depth: (collider.margin - found.distance).max(0.0),
        normal: found.normal,
    }
}

/// Whether a vertex with these bones may touch `collider`: nothing touches what its own frame carries.
pub fn may_touch(skinning: &[SkinWeight], collider: &Collider) -> bool {
    collider
        .body
        .is_none_or(|body| skinning.iter().all(|w| w.bone != body))
}

/// Where a skin vertex is, relative to the instance's origin, m; `unposed` is T.
pub fn contact_point(
    skinning: &[SkinWeight],
    joints: &[DVec3],
    frames: &[Frame],
    unposed: DVec3,
) -> DVec3 {
    displacement::position(skinning, joints, frames, unposed)
}

/// ℓ of the vertex's own blocks, in local order: c_j: w_j e, ω_j: a_j × e, φ_h: N_hᵀ Bᵀ e. `unposed` is T. Gives Bᵀ e.
pub fn skin_levers<B: Basis>(
    (skinning, basis): (&[SkinWeight], &[B]),
    joints: &[DVec3],
    frames: &[Frame],
    unposed: DVec3,
    direction: DVec3,
    out: &mut [DVec3],
) -> DVec3 {
    let (of_frames, of_handles) = out.split_at_mut(2 * skinning.len());
    let mut pulled = DVec3::ZERO;
    for (w, out) in skinning.iter().zip(of_frames.chunks_exact_mut(2)) {
        let j = w.bone as usize;
        let rotation = frames[j].rotation;
        let arm = w.weight * (rotation * (unposed - joints[j]));
        out[0] = w.weight * direction;
        out[1] = arm.cross(direction);
        pulled += w.weight * (rotation.transpose() * direction);
    }
    for (n, out) in basis.iter().zip(of_handles) {
        *out = n.pull_back(pulled);
    }
    pulled
}

/// ℓ of the body's blocks: z moves by −δc − δω × r with r = x − c, so c: −e, ω: −r × e.
pub fn body_levers(body: &Frame, point: DVec3, direction: DVec3) -> [DVec3; 2] {
    [-direction, -(point - body.position).cross(direction)]
}
