//! Where a body is soft: its layer's depth, vertex by vertex.
//!
//! A vertex over a thick layer moves, one over a thin layer (a finger, an ear, the scalp of a whole
//! body) hardly does. Softness is depth relative to what is deep for that body, so it says the same of a
//! hand alone and of a person.

use crate::body::Body;
use crate::math::NearestPoint;
use glam::DVec3;
use supple::internal::math::par_map;
use supple::model::{Avatar, TetMesh};

/// Below this softness no handle stands by itself: tissue sways with the square of its depth, a tenth of what is deep.
pub(crate) const STIFF: f64 = 0.3;

/// The part of the skin's area that counts as deep in full.
const DEEPEST_AREA: f64 = 0.15;

/// How soft a body is, and where.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Softness {
    /// Depth of the layer under each skin vertex, m: how far the nearest node is that a bone holds.
    pub depth: Vec<f64>,
    /// What is deep: 15 % of the skin's area lie over more than this, m.
    pub deep: f64,
    /// min(1, depth/deep) of each skin vertex.
    pub softness: Vec<f64>,
    /// ∫ softness² dA over what is not stiff, m²: the area that handles share, since their spacing goes
    /// with 1/softness.
    pub soft_area: f64,
    /// How much denser soft handles stand over each skin vertex than by its softness alone; none where nowhere.
    pub drawn: Vec<f64>,
}

impl Softness {
    /// Measures a body whose layer is meshed. All soft where no bone holds a node.
    pub fn of(body: &Body) -> Self {
        let layer = &body.layer;
        let areas = body.skin.vertex_areas();
        Self::measured(
            &layer.mesh,
            &layer.bone_of_node,
            &body.skin.positions,
            &areas,
        )
    }

    /// Measures the skin of a baked avatar's tissue, attached vertices left out.
    pub fn of_avatar(avatar: &Avatar) -> Self {
        let (layer, vertices) = (&avatar.layer, avatar.tissue_vertices());
        let (skin, areas) = (&avatar.skin.position, &avatar.skin.measure);
        Self::measured(
            &layer.mesh,
            &layer.bone_of_node,
            &skin[..vertices],
            &areas[..vertices],
        )
    }

    fn measured(
        mesh: &TetMesh,
        bone_of_node: &[Option<u32>],
        skin: &[DVec3],
        areas: &[f64],
    ) -> Self {
        let nodes = bone_of_node.iter().zip(&mesh.nodes);
        let held: Vec<DVec3> = nodes
            .filter_map(|(bone, &place)| bone.map(|_| place))
            .collect();
        let search = NearestPoint::new(&held);
        let depth = par_map(skin.len(), |v| search.distance(skin[v]));
        let deep = upper_quantile(&depth, areas, DEEPEST_AREA);
        let softness: Vec<f64> = (depth.iter())
            .map(|d| {
                if deep > 0.0 && deep.is_finite() {
                    (d / deep).min(1.0)
                } else {
                    1.0
                }
            })
            .collect();
        let soft_area = (softness.iter().zip(areas))
            .filter(|(s, _)| **s >= STIFF)
            .map(|(s, area)| s * s * area)
            .sum();
        Self {
            depth,
            deep,
            softness,
            soft_area,
            drawn: Vec::new(),
        }
    }
}

/// The value that `share` of the weight lies above.
pub(crate) fn upper_quantile(values: &[f64], weights: &[f64], share: f64) -> f64 {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
    let wanted = share * weights.iter().sum::<f64>();
    let mut sum = 0.0;
    for i in order {
        sum += weights[i];
        if sum >= wanted {
            return values[i];
        }
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limb;

    #[test]
    fn a_limb_is_as_deep_as_its_flesh() {
        let limb = Limb::S;
        let softness = Softness::of(&limb.body().unwrap());
        let flesh = limb.outer_radius - limb.inner_radius;
        assert!(
            (softness.deep / flesh - 1.0).abs() < 0.03,
            "{}",
            softness.deep
        );
        let least = softness.softness.iter().copied().fold(1.0, f64::min);
        assert!(least > 0.9, "{least}");
    }
}
