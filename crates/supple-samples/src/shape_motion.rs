//! Shape directions from bones that grow: each bone's surroundings move affinely, joined at the joints and
//! blended by the skin weights.

use glam::{DMat3, DVec3};
use supple::model::SkinWeight;

/// How a bone's surroundings grow: relative rates along the columns of an orthonormal frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Growth {
    pub frame: DMat3,
    pub rate: DVec3,
}

/// x ↦ linear · x + offset: the displacement of one bone's surroundings.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    linear: DMat3,
    offset: DVec3,
}

impl Motion {
    pub fn at(&self, x: DVec3) -> DVec3 {
        self.linear * x + self.offset
    }

    /// The same with everything carried along.
    pub fn carried(self, by: DVec3) -> Self {
        Self {
            offset: self.offset + by,
            ..self
        }
    }
}

/// The motion of every bone; a child moves with its parent at their joint, and the root about the origin.
pub(super) fn joined_motions(
    grows: &[Growth],
    joints: &[DVec3],
    parent: impl Fn(usize) -> Option<u32>,
) -> Vec<Motion> {
    let mut all: Vec<Motion> = Vec::with_capacity(grows.len());
    for (bone, &Growth { frame, rate }) in grows.iter().enumerate() {
        let linear = frame * DMat3::from_diagonal(rate) * frame.transpose();
        let origin = match parent(bone) {
            Some(p) => all[p as usize].at(joints[bone]),
            None => DVec3::ZERO,
        };
        all.push(Motion {
            linear,
            offset: origin - linear * joints[bone],
        });
    }
    all
}

/// The motion at `x` of a vertex with these bones.
pub(super) fn blended(motions: &[Motion], row: &[SkinWeight], x: DVec3) -> DVec3 {
    row.iter()
        .map(|w| w.weight * motions[w.bone as usize].at(x))
        .sum()
}

/// Gram–Schmidt in the area-weighted product: orthogonal, as principal components are. Later
/// directions say what earlier ones do not; joints follow, since all is linear.
pub(super) fn orthogonalise(areas: &[f64], vertices: &mut [Vec<DVec3>], joints: &mut [Vec<DVec3>]) {
    let product = |a: &[DVec3], b: &[DVec3]| -> f64 {
        let terms = a.iter().zip(b).zip(areas);
        terms.map(|((u, v), area)| area * u.dot(*v)).sum()
    };
    let subtract = |from: &mut [DVec3], what: &[DVec3], scale: f64| {
        from.iter_mut()
            .zip(what)
            .for_each(|(f, w)| *f -= scale * *w);
    };
    for k in 1..vertices.len() {
        for l in 0..k {
            let (before, rest) = vertices.split_at_mut(k);
            let scale = product(&rest[0], &before[l]) / product(&before[l], &before[l]);
            subtract(&mut rest[0], &before[l], scale);
            let (before, rest) = joints.split_at_mut(k);
            subtract(&mut rest[0], &before[l], scale);
        }
    }
}
