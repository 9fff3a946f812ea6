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
    /// Outward normal of the collider, in world axes.
    pub normal: DVec3,
}

/// What a side of a contact moves with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ContactSide {
    /// A vertex of the skin: with the bones and handles of its rows.
    Skin {
        /// Which vertex.
        vertex: u32,
    },
    /// A point fixed to a collider: with the collider's frame.
    Collider {
        /// Which collider.
        collider: u32,
    },
}

/// An active contact. Side 0 is pushed along `normal`, side 1 against it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The two bodies.
    pub sides: [ContactSide; 2],
    /// Outward unit normal of side 1.
    pub normal: DVec3,
    /// δ, m.
    pub depth: f64,
    /// k a, N/m.
    pub stiffness: f64,
}

impl Contact {
    /// k a δ, N.
    pub fn force(&self) -> f64 {
        self.stiffness * self.depth
    }
}

/// How a point of one side moves: x = Σ w_f (frame f) with handles in it, as every material point does.
#[derive(Clone, Copy, Debug)]
pub struct SideMotion<'a, B> {
    /// Frames, bones first, then one for each collider. A frame that is no DoF of the system is kinematic.
    pub frames: &'a [SkinWeight],
    /// Handles.
    pub handles: &'a [B],
}

impl<B: Basis> SideMotion<'_, B> {
    /// ℓ_b = ±Jᵀ_b n of every block b that the side has, in local order: c and ω of each frame below
    /// `dynamic`, then the handles. The energy's gradient is −k a δ ℓ, its Hessian k a ℓ ℓᵀ.
    pub fn levers(
        &self,
        dynamic: usize,
        joints: &[DVec3],
        frames: &[Frame],
        unposed: DVec3,
        normal: DVec3,
        out: &mut [DVec3],
    ) {
        let mut out = out.iter_mut();
        let mut push = |lever| {
            if let Some(slot) = out.next() {
                *slot = lever;
            }
        };
        let mut pulled = DVec3::ZERO;
        for w in self.frames.iter().filter(|w| (w.bone as usize) < dynamic) {
            let j = w.bone as usize;
            let rotation = frames[j].rotation;
            let arm = w.weight * (rotation * (unposed - joints[j]));
            push(w.weight * normal);
            push(arm.cross(normal));
            pulled += w.weight * (rotation.transpose() * normal);
        }
        for n in self.handles {
            push(n.pull_back(pulled));
        }
    }
}

/// δ and n at `point`, both relative to the instance's origin.
pub fn contact(point: DVec3, collider: &Collider) -> Candidate {
    let found = collider.signed_distance(point);
    Candidate {
        depth: (collider.margin - found.distance).max(0.0),
        normal: found.normal,
    }
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
