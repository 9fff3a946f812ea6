//! Momentum and mechanical energy of an avatar on its way from one state to the next.

use super::displacement::{position, unposed_displacement};
use super::pose_blend::pose_blend;
use crate::model::{Avatar, State, pose_feature};
use glam::DVec3;

/// What moves, and how high it is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mechanics {
    /// Linear momentum, kg m/s.
    pub momentum: DVec3,
    /// Kinetic energy, J.
    pub kinetic: f64,
    /// Energy under gravity, J; 0 where everything lies in the origin.
    pub gravity: f64,
}

impl Mechanics {
    /// Kinetic energy and that under gravity, J.
    pub fn energy(&self) -> f64 {
        self.kinetic + self.gravity
    }
}

/// Of the tissue's points (mass m_i = ρ w_i) and the rigid frames (second moments S_j, first moment s_j, mass m_j)
/// that go from `before` to `after` in `time_step` (s), with v = (x(after) − x(before))/h and A = \[R | c\] likewise:
///
/// ```text
/// p = Σ_i m_i v_i + Σ_j (m_j ċ_j + Ṙ_j s_j)
/// K = Σ_i ½ m_i |v_i|² + Σ_j ½ tr(Ȧ_j S_j Ȧ_jᵀ)
/// V = −Σ_i m_i g · x_i(after) − Σ_j g · (R_j s_j + m_j c_j)
/// ```
///
/// Rest positions are those of the pose in `before`, as a step has them: a blend shape has no inertia of its own. In V
/// they stay where they are (φ = 0) where the rest shape was captured under gravity (method §5). `gravity` is in m/s².
pub fn mechanics(
    avatar: &Avatar,
    before: &State,
    after: &State,
    time_step: f64,
    gravity: DVec3,
) -> Mechanics {
    let mut out = Mechanics::default();
    for (bone, (a, b)) in (avatar.bone_masses.iter()).zip(before.frames.iter().zip(&after.frames)) {
        let (mass, first) = bone.moments();
        out.momentum += bone.momentum(a, b, time_step);
        out.kinetic += bone.kinetic_energy(a, b, time_step);
        out.gravity -= gravity.dot(b.rotation * first + mass * b.position);
    }
    let (points, skeleton) = (&avatar.cubature, &avatar.skeleton);
    let feature = pose_feature(&skeleton.parents, &before.frames);
    let mut rest = vec![DVec3::ZERO; points.len()];
    pose_blend(&points.position, &points.pose_blend, &feature, 0, &mut rest);
    for (i, rest) in rest.into_iter().enumerate() {
        let (skinning, basis) = (points.skinning.row(i), points.basis.row(i));
        let at = |state: &State, unposed: DVec3| {
            position(skinning, &skeleton.joints, &state.frames, unposed)
        };
        let moved = |state: &State| rest + unposed_displacement(basis, &state.handles);
        let mass = avatar.density * points.measure[i];
        let end = at(after, moved(after));
        let velocity = (end - at(before, moved(before))) / time_step;
        out.momentum += mass * velocity;
        out.kinetic += 0.5 * mass * velocity.length_squared();
        let weighed = match avatar.captured_under_gravity {
            true => at(after, rest),
            false => end,
        };
        out.gravity -= mass * gravity.dot(weighed);
    }
    out
}
