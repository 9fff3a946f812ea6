//! The drawn skin of one instance.

use super::Basis;
use super::asset::Asset;
use super::displacement::unposed_displacement;
use super::fine_skin::FineSkin;
use super::normals::normal;
use super::pose_blend::add_offsets;
use super::skin::skin;
use crate::math::{Strided, par_each, par_split};
use crate::model::{State, pose_feature_into};
use crate::potential::PreviousSkin;
use crate::potential::cpu::begin_step::VERTEX_GRAIN;
use glam::DVec3;

/// Positions (m, world) and unit normals, and the rest shape they came from.
#[derive(Default)]
pub(super) struct PosedSkin {
    /// The pose feature of `blended`.
    feature: Vec<f64>,
    /// X and the blend shapes of the drawn pose: the next step starts from it, as a rule. A host's offsets are not in it.
    blended: Vec<DVec3>,
    pub positions: Vec<DVec3>,
    /// Positions at the step before, m.
    pub previous: Vec<DVec3>,
    pub normals: Vec<DVec3>,
}

impl PosedSkin {
    /// x̄ of the skin in the pose of `feature`, but for a host's offsets, if that was drawn last.
    pub fn blended(&self, feature: &[f64]) -> Option<&[DVec3]> {
        let drawn = !self.blended.is_empty() && self.feature == feature;
        drawn.then_some(&self.blended[..])
    }

    /// Poses the skin of `state` with x̄ of its own pose and `offsets`.
    pub fn pose<B: Basis>(
        &mut self,
        (asset, fine): (&Asset<B>, &FineSkin),
        state: &State,
        offsets: &[[f32; 3]],
        previous: PreviousSkin,
    ) {
        if previous == PreviousSkin::Last {
            std::mem::swap(&mut self.previous, &mut self.positions);
        }
        let (skeleton, points) = (&asset.avatar.skeleton, &asset.avatar.skin);
        pose_feature_into(&skeleton.parents, &state.frames, &mut self.feature);
        let feature = &self.feature;
        self.blended.resize(points.len(), DVec3::ZERO);
        self.positions.resize(points.len(), DVec3::ZERO);
        self.normals.resize(points.len(), DVec3::ZERO);
        let chunks = points.len().div_ceil(VERTEX_GRAIN);
        let parts = (
            Strided::new(VERTEX_GRAIN, &mut self.blended),
            Strided::new(VERTEX_GRAIN, &mut self.positions),
        );
        par_split(chunks, 1, parts, |chunk, (blended, out)| {
            let first = chunk * VERTEX_GRAIN;
            (asset.skin_columns).blend(&points.position, feature, first, blended);
            out.copy_from_slice(blended);
            add_offsets(out, offsets.get(first..).unwrap_or_default());
            for (v, x) in (first..).zip(out) {
                let rest = match fine.row(v) {
                    [] => *x,
                    fine => *x + unposed_displacement(fine, &state.handles),
                };
                *x = skin(
                    asset.skin.skinning.row(v),
                    asset.skin.basis.row(v),
                    &skeleton.joints,
                    &state.frames,
                    &state.handles,
                    rest,
                );
            }
        });
        let positions = &self.positions;
        par_each(&mut self.normals, VERTEX_GRAIN, |v, out| {
            *out = normal(positions, v, asset.vertex_triangles.row(v));
        });
        if previous == PreviousSkin::New {
            self.previous.clone_from(positions);
        }
    }
}
