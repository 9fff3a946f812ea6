//! What several figures measure.

use glam::{DMat3, DVec3};
use supple::internal::cpu::displacement::blended_rotation;
use supple::internal::cpu::elasticity::displacement_gradient;
use supple::internal::cpu::skin_displacement;
use supple::internal::math::par_map;
use supple::model::{Avatar, State};
use supple_bake::math::NearestPoint;

/// B U φ at each skin vertex, m: what the tissue adds to the skinned shape in the world.
pub(super) fn world_displacement(avatar: &Avatar, state: &State) -> Vec<DVec3> {
    let rows = avatar.skin.skinning.iter();
    rows.zip(skin_displacement(avatar, state))
        .map(|(row, d)| blended_rotation(row, &state.frames) * d)
        .collect()
}

/// det F at each cubature point; of each tet where all of them are points.
pub(super) fn volume_ratios(avatar: &Avatar, state: &State) -> Vec<f64> {
    let points = &avatar.cubature;
    par_map(points.len(), |i| {
        let h = displacement_gradient(points.basis.row(i), &state.handles);
        (DMat3::IDENTITY + h).determinant()
    })
}

/// Depth of the tissue under each skin vertex, m: how far the nearest node is that a bone holds.
pub(super) fn depth(avatar: &Avatar) -> Vec<f64> {
    let layer = &avatar.layer;
    let held: Vec<DVec3> = (layer.mesh.nodes.iter().zip(&layer.bone_of_node))
        .filter_map(|(place, bone)| bone.map(|_| *place))
        .collect();
    let search = NearestPoint::new(&held);
    let points = avatar.skin.position.iter();
    points.map(|p| search.distance(*p)).collect()
}

/// The value above which a `share` of the weight lies.
pub(super) fn upper_quantile(values: &[f64], weights: &[f64], share: f64) -> f64 {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    let wanted = share * weights.iter().sum::<f64>();
    let mut sum = 0.0;
    for v in order {
        sum += weights[v];
        if sum >= wanted {
            return values[v];
        }
    }
    f64::NEG_INFINITY
}

/// Longest of `vectors`.
pub(super) fn longest(vectors: impl IntoIterator<Item = DVec3>) -> f64 {
    vectors.into_iter().map(DVec3::length).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_upper_quantile_leaves_its_share_above() {
        let values: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(upper_quantile(&values, &[1.0; 100], 0.1), 90.0);
        assert_eq!(upper_quantile(&values, &[1.0; 100], 1.0), 0.0);
    }
}
