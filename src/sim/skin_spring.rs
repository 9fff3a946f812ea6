//! Springs between points of the skin and places in the world: what a hand does that takes hold of flesh or bone.
//!
//! E = ½ k |x_v(q) − p|², with x̄ of θⁿ as contact has it. With a_j = w_j R_j (T − J_j):
//!
//! ```text
//! ∂x/∂c_j = w_j I      ∂x/∂ω_j = −[a_j]×      ∂x/∂φ_h = B U_h
//! ```
//!
//! It is added on the CPU as the bones' own terms are, whatever evaluates the tissue.

use crate::math::skew;
use crate::model::skeleton::pose_feature_into;
use crate::model::{Avatar, BasisEntry, Frame, Skeleton, SkinWeight, State};
use crate::potential::BlockPattern;
use crate::potential::cpu::contact::ContactRow;
use crate::potential::cpu::displacement::{blended_rotation, position, unposed_displacement};
use crate::potential::cpu::geometric::{Vertex, add_geometric};
use crate::skeleton::FrameHessian;
use crate::{Error, Result};
use glam::{DMat3, DVec3};

/// A spring from a vertex of the skin to a place. Its reaction is on whoever holds that place: nothing else feels it.
#[derive(Clone, Debug, PartialEq)]
pub struct SkinSpring {
    vertex: usize,
    /// p, m, in the world.
    pub place: DVec3,
    /// k, N/m.
    pub stiffness: f64,
    /// X, m.
    rest: DVec3,
    skinning: Vec<SkinWeight>,
    basis: Vec<BasisEntry>,
    /// (fine handle, U), handles rising, and the first of the slots that stand for those awake.
    fine: Vec<(u32, f32)>,
    first_slot: u32,
    /// Pose blend shapes at the vertex: one for each feature, or none.
    columns: Vec<[f32; 3]>,
}

impl SkinSpring {
    /// A spring of `stiffness` k (N/m) from `vertex` of the skin of `avatar` to `place` (m, world).
    ///
    /// # Errors
    /// [`Error::Invalid`] of a vertex that is not there, a place that is not finite, or a negative stiffness.
    pub fn new(avatar: &Avatar, vertex: usize, place: DVec3, stiffness: f64) -> Result<Self> {
        let (skin, field) = (&avatar.skin, "skin_spring");
        let refuse = |key: &str, problem: String| Error::invalid(format!("{field}.{key}"), problem);
        if vertex >= skin.len() {
            let problem = format!("{vertex}; the skin has {} vertices", skin.len());
            return Err(refuse("vertex", problem));
        }
        let blend = &skin.pose_blend;
        let column = |k: usize| blend.columns[k * skin.len() + vertex];
        let spring = Self {
            vertex,
            place,
            stiffness,
            rest: skin.position[vertex],
            skinning: skin.skinning.row(vertex).to_vec(),
            basis: skin.basis.row(vertex).to_vec(),
            fine: match avatar.fine.slots {
                0 => Vec::new(),
                _ => avatar.fine.skin.row(vertex).to_vec(),
            },
            first_slot: avatar.coarse_handles() as u32,
            columns: (0..blend.features).map(column).collect(),
        };
        spring.validate().map_err(|e| e.within(field))?;
        Ok(spring)
    }

    /// Which vertex of the skin.
    pub fn vertex(&self) -> usize {
        self.vertex
    }

    /// Where the vertex is in the reference shape, m.
    pub(super) fn rest(&self) -> DVec3 {
        self.rest
    }

    /// Adds the fine handles that are awake in `state` to what moves the vertex.
    fn wake(&mut self, state: &State) {
        let slots = state.awake.iter().zip(self.first_slot..);
        let fine = &self.fine;
        self.basis.extend(slots.filter_map(|(handle, slot)| {
            let at = fine.binary_search_by_key(handle, |(h, _)| *h).ok()?;
            Some(BasisEntry {
                handle: slot,
                value: f64::from(fine[at].1),
                gradient: DVec3::ZERO,
            })
        }));
    }

    /// Checks what a host may have written.
    pub(super) fn validate(&self) -> Result<()> {
        if !self.place.is_finite() {
            return Err(Error::invalid("place", "is not finite"));
        }
        if !(self.stiffness >= 0.0 && self.stiffness.is_finite()) {
            let problem = format!("{}; must be 0 or positive (N/m)", self.stiffness);
            return Err(Error::invalid("stiffness", problem));
        }
        Ok(())
    }

    fn is_of(&self, state: &State) -> bool {
        let bones = self.skinning.iter().map(|w| w.bone as usize);
        let handles = self.basis.iter().map(|u| u.handle as usize);
        (bones.max()).is_none_or(|bone| bone < state.frames.len())
            && (handles.max()).is_none_or(|handle| handle < state.handles.len())
    }
}

/// The springs of one instance in a step.
#[derive(Clone, Debug, Default)]
pub(super) struct SkinPulls {
    springs: Vec<SkinSpring>,
    /// x̄ of each, m.
    unposed: Vec<DVec3>,
    joints: Vec<DVec3>,
    feature: Vec<f64>,
}

impl SkinPulls {
    /// `springs` in a step that starts at `current` (qⁿ) with a host's `offsets` of the skin.
    pub fn restart(
        &mut self,
        springs: &Vec<SkinSpring>,
        skeleton: &Skeleton,
        current: &State,
        offsets: &[[f32; 3]],
    ) -> Result<()> {
        self.springs.clone_from(springs);
        self.unposed.clear();
        if self.springs.is_empty() {
            return Ok(());
        }
        self.joints.clear();
        self.joints.extend_from_slice(&skeleton.joints);
        (self.springs.iter_mut()).for_each(|spring| spring.wake(current));
        pose_feature_into(&skeleton.parents, &current.frames, &mut self.feature);
        for spring in &self.springs {
            spring.validate().map_err(|e| e.within("skin_springs"))?;
            if !spring.is_of(current) {
                let problem = "was made for another avatar";
                return Err(Error::invalid("skin_springs", problem));
            }
            let vector = |c: &[f32; 3]| DVec3::from(c.map(f64::from));
            let blended = spring.columns.iter().zip(&self.feature);
            let blended: DVec3 = blended.map(|(column, f)| *f * vector(column)).sum();
            let offset = offsets.get(spring.vertex).map_or(DVec3::ZERO, vector);
            self.unposed.push(spring.rest + blended + offset);
        }
        Ok(())
    }

    /// E(state) − E(base), J.
    pub fn difference(&self, base: &State, state: &State) -> f64 {
        let pulls = self.springs.iter().zip(&self.unposed);
        let difference = |(spring, rest): (&SkinSpring, &DVec3)| {
            let place = |s: &State| self.place(spring, self.displaced(spring, *rest, s), s);
            let (from, to) = (place(base), place(state));
            let moved = to - from;
            spring.stiffness * moved.dot(from - spring.place + 0.5 * moved)
        };
        pulls.map(difference).sum()
    }

    /// Adds the gradient and the Gauss–Newton Hessian at `state` to those of tissue and bones.
    pub fn add_derivatives(
        &self,
        state: &State,
        gradient: &mut [f64],
        packed: &mut [[f64; 9]],
        pattern: &BlockPattern,
    ) {
        self.add(state, gradient, &mut FrameHessian::new(packed, pattern));
    }

    /// Adds the gradient at `state` alone, as far as `gradient` has room: that by frames, or all of it.
    pub fn add_gradient(&self, state: &State, gradient: &mut [f64]) {
        self.add(state, gradient, &mut FrameHessian::none());
    }

    fn add(&self, state: &State, gradient: &mut [f64], hessian: &mut FrameHessian<'_>) {
        for (spring, rest) in self.springs.iter().zip(&self.unposed) {
            let unposed = self.displaced(spring, *rest, state);
            let force = spring.stiffness * (self.place(spring, unposed, state) - spring.place);
            let blended = blended_rotation(&spring.skinning, &state.frames);
            let count = 2 * spring.skinning.len() + spring.basis.len();
            let jacobian = |k| self.jacobian(spring, unposed, blended, state, k);
            for i in 0..count {
                let (row, left) = jacobian(i);
                if let Some(out) = gradient.get_mut(3 * row..3 * row + 3) {
                    let part = (left.transpose() * force).to_array();
                    out.iter_mut().zip(part).for_each(|(sum, g)| *sum += g);
                }
                for j in 0..=i {
                    let (column, right) = jacobian(j);
                    hessian.add(row, column, left.transpose() * right * spring.stiffness);
                }
            }
        }
    }

    /// Adds force times second derivatives of the points: with it the Hessian is exact.
    pub fn add_geometric(&self, state: &State, packed: &mut [[f64; 9]], pattern: &BlockPattern) {
        for (spring, rest) in self.springs.iter().zip(&self.unposed) {
            let unposed = self.displaced(spring, *rest, state);
            let force = spring.stiffness * (self.place(spring, unposed, state) - spring.place);
            let row = ContactRow {
                vertex: spring.vertex as u32,
                body: None,
                direction: force,
                force: 1.0,
                stiffness: 0.0,
            };
            let vertex = Vertex {
                skinning: &spring.skinning,
                basis: &spring.basis,
                fine: &[],
                unposed,
            };
            let into = (pattern, &[][..]);
            add_geometric(into, &row, &vertex, &self.joints, &state.frames, packed);
        }
    }

    /// Block and ∂x/∂(block) of the `k`th block that moves a point.
    fn jacobian(
        &self,
        spring: &SkinSpring,
        unposed: DVec3,
        blended: DMat3,
        state: &State,
        k: usize,
    ) -> (usize, DMat3) {
        let (space, bones) = (state.space(), spring.skinning.len());
        if k >= 2 * bones {
            let handle = &spring.basis[k - 2 * bones];
            let block = space.handle_block(handle.handle as usize);
            return (block, blended * handle.value);
        }
        let SkinWeight { bone, weight } = spring.skinning[k / 2];
        let bone = bone as usize;
        let block = space.frame_block(bone) + k % 2;
        if k.is_multiple_of(2) {
            return (block, DMat3::from_diagonal(DVec3::splat(weight)));
        }
        let arm = weight * (state.frames[bone].rotation * (unposed - self.joints[bone]));
        (block, -skew(arm))
    }

    /// T, m.
    fn displaced(&self, spring: &SkinSpring, rest: DVec3, state: &State) -> DVec3 {
        rest + unposed_displacement(&spring.basis, &state.handles)
    }

    /// x, m.
    fn place(&self, spring: &SkinSpring, unposed: DVec3, state: &State) -> DVec3 {
        let frames: &[Frame] = &state.frames;
        position(&spring.skinning, &self.joints, frames, unposed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random_avatar::{random_avatar, random_state};

    /// The exact Hessian is the gradient's differences, symmetrised over the order of two rotations; the gradient is the
    /// energy's.
    #[test]
    fn derivatives_are_differences_with_the_geometric_term() {
        const STEP: f64 = 1e-6;
        let avatar = random_avatar(5, 3, 6, 12, 20);
        let (start, state) = (avatar.rest_state(), random_state(6, &avatar, 0.7, 0.02));
        let spring = SkinSpring::new(&avatar, 7, DVec3::new(0.3, -0.2, 0.5), 40.0).unwrap();
        let mut pulls = SkinPulls::default();
        let restarted = pulls.restart(&vec![spring], &avatar.skeleton, &start, &[]);
        restarted.unwrap();
        let pattern = BlockPattern::new(avatar.space(), &[], &[&avatar.skin]);
        let dofs = avatar.space().dofs();
        let (mut gradient, mut hessian) = (vec![0.0; dofs], vec![[0.0; 9]; pattern.len()]);
        pulls.add_derivatives(&state, &mut gradient, &mut hessian, &pattern);
        pulls.add_geometric(&state, &mut hessian, &pattern);
        let moved = |k: usize, by: f64| {
            let step: Vec<f64> = (0..dofs).map(|i| f64::from(u8::from(i == k))).collect();
            state.moved(&step, by)
        };
        let mut columns = Vec::new();
        for k in 0..dofs {
            let (ahead, behind) = (moved(k, STEP), moved(k, -STEP));
            let slope = pulls.difference(&behind, &ahead) / (2.0 * STEP);
            assert!((gradient[k] - slope).abs() < 1e-6, "{k}: {slope}");
            let of = |state: &State| {
                let mut gradient = vec![0.0; dofs];
                pulls.add_gradient(state, &mut gradient);
                gradient
            };
            let pairs = of(&ahead).into_iter().zip(of(&behind));
            let column: Vec<f64> = pairs.map(|(a, b)| (a - b) / (2.0 * STEP)).collect();
            columns.push(column);
        }
        let mut largest = 0.0f64;
        for i in 0..dofs {
            for k in 0..=i {
                let block = pattern.find(i / 3, k / 3);
                let entry = block.map_or(0.0, |b| hessian[b][i % 3 + 3 * (k % 3)]);
                let expected = 0.5 * (columns[k][i] + columns[i][k]);
                assert!(
                    (entry - expected).abs() < 1e-5,
                    "({i}, {k}): {entry}, {expected}"
                );
                largest = largest.max(expected.abs());
            }
        }
        assert!(largest > 1.0, "{largest}");
    }
}
