//! Gravity as a function of the pose alone.

use super::term::{FrameHessian, FrameTerm, add_block, rotation_curvature};
use crate::math::Rows;
use crate::model::{Avatar, Frame, pose_features};
use glam::{DMat3, DVec3};

/// Mass and first moment of the matter that each bone carries, about its joint.
///
/// Of the tissue: M0_j = Σ m_i w_ij and M1_j = Σ m_i w_ij (x̄_i − J_j) over the cubature points. x̄ is
/// linear in the pose feature and in a host's offsets, and so is M1.
#[derive(Clone, Debug)]
pub struct TissueMoments {
    parents: Vec<Option<u32>>,
    /// M0, kg.
    mass: Vec<f64>,
    /// M1 of the undeformed reference shape, kg m.
    first: Vec<DVec3>,
    /// ∂M1_j/∂feature_k at `k * bones + j`, kg m.
    blend: Vec<DVec3>,
    /// ∂M1_j/∂u_v of each skin vertex v: (j, Σ m_i w_ij E_iv), kg.
    offsets: Rows<(u32, f64)>,
}

impl TissueMoments {
    /// The moments of `avatar`'s cubature points.
    pub fn new(avatar: &Avatar) -> Self {
        let (points, bones) = (&avatar.cubature, avatar.skeleton.len());
        let features = points.pose_blend.features;
        let mut out = Self {
            parents: avatar.skeleton.parents.clone(),
            mass: vec![0.0; bones],
            first: vec![DVec3::ZERO; bones],
            blend: vec![DVec3::ZERO; features * bones],
            offsets: offset_moments(avatar),
        };
        for i in 0..points.len() {
            for w in points.skinning.row(i) {
                let j = w.bone as usize;
                let share = avatar.density * points.measure[i] * w.weight;
                out.mass[j] += share;
                out.first[j] += share * (points.position[i] - avatar.skeleton.joints[j]);
                for k in 0..features {
                    let column = points.pose_blend.columns[k * points.len() + i];
                    out.blend[k * bones + j] += share * DVec3::from(column.map(f64::from));
                }
            }
        }
        out
    }

    /// Adds M0, and M1 with x̄ of the pose `frames` and the skin's `offsets`, times `factor` to the moments of each bone.
    fn add_to(
        &self,
        factor: f64,
        moments: &mut [(f64, DVec3)],
        frames: &[Frame],
        offsets: &[[f32; 3]],
    ) {
        for ((mass, first), (m0, m1)) in moments.iter_mut().zip(self.mass.iter().zip(&self.first)) {
            *mass += factor * m0;
            *first += factor * *m1;
        }
        let columns = self.blend.chunks_exact(self.mass.len().max(1));
        for (value, column) in pose_features(&self.parents, frames).zip(columns) {
            for ((_, first), share) in moments.iter_mut().zip(column) {
                *first += factor * value * *share;
            }
        }
        for (offset, shares) in offsets.iter().zip(self.offsets.iter()) {
            let offset = factor * DVec3::from(offset.map(f64::from));
            for &(j, share) in shares {
                moments[j as usize].1 += share * offset;
            }
        }
    }
}

/// Of each skin vertex, the bones whose tissue follows its offset, and by what mass.
fn offset_moments(avatar: &Avatar) -> Rows<(u32, f64)> {
    let points = &avatar.cubature;
    let mut rows = vec![Vec::<(u32, f64)>::new(); avatar.tissue_vertices()];
    for (i, followed) in avatar.pose_extension.iter().enumerate() {
        for w in points.skinning.row(i) {
            let mass = avatar.density * points.measure[i] * w.weight;
            for &(v, share) in followed {
                let (row, mass) = (&mut rows[v as usize], mass * f64::from(share));
                match row.iter_mut().find(|(bone, _)| *bone == w.bone) {
                    Some((_, sum)) => *sum += mass,
                    None => row.push((w.bone, mass)),
                }
            }
        }
    }
    rows.into_iter().collect()
}

/// E = −Σ_j g · (R_j M1_j + M0_j c_j), over bones and, where the rest shape already sags under
/// gravity, the tissue at φ = 0. Linear in positions: its Gauss–Newton Hessian is 0.
#[derive(Clone, Debug, Default)]
pub struct FrameGravity {
    gravity: DVec3,
    /// (M0, kg; M1, kg m) of each bone.
    moments: Vec<(f64, DVec3)>,
}

impl FrameGravity {
    /// The bones' own moments `(mass, first)`, and the tissue's with x̄ of the pose `current` and of `offsets`, times a
    /// factor.
    pub fn new(
        gravity: DVec3,
        bones: &[(f64, DVec3)],
        tissue: Option<(&TissueMoments, f64)>,
        current: &[Frame],
        offsets: &[[f32; 3]],
    ) -> Self {
        let mut out = Self::default();
        out.restart(gravity, bones, tissue, current, offsets);
        out
    }

    /// [`FrameGravity::new`] in the memory of the last step's.
    pub(super) fn restart(
        &mut self,
        gravity: DVec3,
        bones: &[(f64, DVec3)],
        tissue: Option<(&TissueMoments, f64)>,
        current: &[Frame],
        offsets: &[[f32; 3]],
    ) {
        self.gravity = gravity;
        self.moments.clear();
        self.moments.extend(bones);
        if let Some((tissue, factor)) = tissue {
            tissue.add_to(factor, &mut self.moments, current, offsets);
        }
    }

    /// The weight of bone `j`, N, and its moment about the joint where the bone has this `rotation`, N·m.
    pub(super) fn wrench(&self, j: usize, rotation: &DMat3) -> (DVec3, DVec3) {
        // Frames that stand for bodies of a world have none.
        let (mass, first) = self.moments.get(j).copied().unwrap_or_default();
        let lever = *rotation * first;
        (mass * self.gravity, lever.cross(self.gravity))
    }
}

impl FrameTerm for FrameGravity {
    fn difference(&self, base: &[Frame], frames: &[Frame]) -> f64 {
        let moved = |(j, (mass, first)): (usize, &(f64, DVec3))| {
            (frames[j].rotation - base[j].rotation) * *first
                + *mass * (frames[j].position - base[j].position)
        };
        let works = self.moments.iter().enumerate();
        -works.map(|m| self.gravity.dot(moved(m))).sum::<f64>()
    }

    fn add_derivatives(
        &self,
        frames: &[Frame],
        gradient: &mut [f64],
        _hessian: &mut FrameHessian<'_>,
    ) {
        for (j, (frame, (mass, first))) in frames.iter().zip(&self.moments).enumerate() {
            add_block(gradient, 2 * j, -mass * self.gravity);
            let lever = frame.rotation * *first;
            add_block(gradient, 2 * j + 1, -lever.cross(self.gravity));
        }
    }

    fn add_geometric(&self, frames: &[Frame], hessian: &mut FrameHessian<'_>) {
        for (j, (frame, (_, first))) in frames.iter().zip(&self.moments).enumerate() {
            let lever = frame.rotation * *first;
            let rotation = 2 * j + 1;
            hessian.add(rotation, rotation, rotation_curvature(-self.gravity, lever));
        }
    }
}
