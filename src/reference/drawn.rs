//! The drawn skin of one instance.

use super::asset::Asset;
use super::step::VERTEX_GRAIN;
use super::{Basis, normals::normal, pose_blend::pose_blend, skin::skin};
use crate::math::{Strided, par_each, par_split};
use crate::model::{State, pose_feature_into};
use glam::DVec3;

/// Positions (m, world) and unit normals.
#[derive(Default)]
pub(super) struct Drawn {
    pub positions: Vec<DVec3>,
    pub normals: Vec<DVec3>,
}

impl Drawn {
    /// Poses the skin of `state` with x̄ of its own pose.
    pub fn pose<B: Basis>(&mut self, asset: &Asset<B>, state: &State, feature: &mut Vec<f64>) {
        let (skeleton, points) = (&asset.avatar.skeleton, &asset.avatar.skin);
        pose_feature_into(&skeleton.parents, &state.frames, feature);
        let feature = &*feature;
        self.positions.resize(points.len(), DVec3::ZERO);
        self.normals.resize(points.len(), DVec3::ZERO);
        let chunks = points.len().div_ceil(VERTEX_GRAIN);
        let parts = Strided::new(VERTEX_GRAIN, &mut self.positions);
        par_split(chunks, 1, parts, |chunk, out| {
            let first = chunk * VERTEX_GRAIN;
            pose_blend(&points.position, &points.pose_blend, feature, first, out);
            for (v, x) in (first..).zip(out) {
                *x = skin(
                    asset.skin.skinning.row(v),
                    asset.skin.basis.row(v),
                    &skeleton.joints,
                    &state.frames,
                    &state.handles,
                    *x,
                );
            }
        });
        let positions = &self.positions;
        par_each(&mut self.normals, VERTEX_GRAIN, |v, out| {
            *out = normal(positions, v, asset.vertex_triangles.row(v));
        });
    }
}
