//! Where inertia alone would move a point in a step: with T at qⁿ and ΔT_k = Σ_h N_h c_k (φⁿ⁻ᵏ − φⁿ)_h,
//!
//! ```text
//! ŷ = Σ_{k≥1} c_k (x(qⁿ⁻ᵏ) − x(qⁿ)) = Σ_j w_j ( A_j (T − J_j) + b_j + Σ_k R_j(qⁿ⁻ᵏ) ΔT_k )
//! [A_j | b_j] = Σ_k c_k ([R_j | c_j](qⁿ⁻ᵏ) − [R_j | c_j](qⁿ))
//! ```
//!
//! from increments only, and with this step's x̄ in all states: the shape's own motion has no inertia.

use super::Basis;
use super::displacement::unposed_displacement;
use crate::model::{InertialTarget, SkinWeight, State};
use glam::{DMat3, DVec3};

/// What inertia takes from the past of frames and handles.
#[derive(Clone, Debug, Default)]
pub struct PastMotion {
    /// A_j and b_j (m) of each frame.
    pub frames: Vec<(DMat3, DVec3)>,
    /// R_j of each past state.
    pub rotations: [Vec<DMat3>; 3],
    /// c_k (φⁿ⁻ᵏ − φⁿ) of each, m.
    pub handles: [Vec<DVec3>; 3],
    /// How many past states count.
    pub terms: usize,
}

impl PastMotion {
    /// Refills everything; allocates the first time only.
    pub fn set(&mut self, target: &InertialTarget<'_>, current: &State) {
        self.frames.clear();
        let frames = current.frames.iter().enumerate();
        (self.frames).extend(frames.map(|(j, frame)| target.frame(j, frame)));
        self.terms = 0;
        let memory = self.rotations.iter_mut().zip(&mut self.handles);
        for ((weight, past), (rotations, handles)) in target.terms().zip(memory) {
            rotations.clear();
            rotations.extend(past.frames.iter().map(|frame| frame.rotation));
            handles.clear();
            let pairs = past.handles.iter().zip(&current.handles);
            handles.extend(pairs.map(|(past, now)| (*past - *now) * weight));
            self.terms += 1;
        }
    }
}

/// ŷ, m, of a point with T = `unposed`.
pub fn inertial_target<B: Basis>(
    skinning: &[SkinWeight],
    basis: &[B],
    joints: &[DVec3],
    past: &PastMotion,
    unposed: DVec3,
) -> DVec3 {
    let mut changes = [DVec3::ZERO; 3];
    for (change, handles) in changes.iter_mut().zip(&past.handles[..past.terms]) {
        *change = unposed_displacement(basis, handles);
    }
    let of_bone = |w: &SkinWeight| {
        let j = w.bone as usize;
        let (turn, shift) = past.frames[j];
        let mut moved = turn * (unposed - joints[j]) + shift;
        for (rotations, change) in past.rotations[..past.terms].iter().zip(&changes) {
            moved += rotations[j] * *change;
        }
        w.weight * moved
    };
    skinning.iter().map(of_bone).sum()
}
