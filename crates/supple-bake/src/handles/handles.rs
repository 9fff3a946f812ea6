//! Where handles stand: on the skin, at nodes or at points inside the volume.

use super::mirror::{Mirror, mirrored_farthest_points};
use super::sampling::{Density, weighted_farthest_points};
use super::softness::Softness;
use crate::basis::Constraints;
use crate::body::Body;
use crate::handles::candidates::{Candidate, candidates};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use supple::internal::math::Rows;
use supple::model::SkinWeight;
use supple::{Error, Result};

/// Some handles: a region (what satisfies every key that is given), and how densely it is sampled. Without count
/// and spacing every candidate becomes a handle: that is an exact list.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct HandleRegion {
    /// What the candidates are.
    pub candidates: HandleCandidates,
    /// Only where one of these bones has the largest weight; none named: everywhere.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bones: Vec<String>,
    /// Only these skin vertices (`skin`) or nodes (`volume`); none named: all.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub vertices: Vec<u32>,
    /// Only where the body's map of this name ([`Body::painted`]) is above 0; its values weigh the density:
    /// handles stand twice as far apart where it is half as large.
    pub painted: Option<String>,
    /// Only inside this box: lowest and highest corner in the reference shape, m.
    pub within: Option<[[f64; 3]; 2]>,
    /// The points themselves (`points`), in the reference shape, m.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<[f64; 3]>,
    /// How many, by farthest-point sampling.
    pub count: Option<usize>,
    /// Or until no candidate is farther than this from a handle, m; where the density varies, in its
    /// densest part.
    pub spacing: Option<f64>,
    /// How far softness ([`Softness`]) draws handles: their spacing goes with softness^−soft, and what is stiff
    /// gets none. Where it is not 0 and the body is its own mirror image, handles come in pairs or on the plane
    /// between its halves. 0 is even; automatic handles have 0.6.
    pub soft: f64,
}

/// What the candidates of a region are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum HandleCandidates {
    /// Skin vertices.
    #[default]
    Skin,
    /// Nodes of the layer that no bone holds, skin included.
    Volume,
    /// Points given by their coordinates, inside the layer.
    Points,
}

/// Handles of a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Handles {
    /// Rest position of each, m.
    pub positions: Vec<DVec3>,
    /// The condition on the nodes that makes U = 1 there.
    pub constraints: Constraints,
    /// How many each region gave, in order.
    pub per_region: Vec<usize>,
}

impl Handles {
    /// The handles of all `regions` in order, each region keeping away from those before it.
    /// `node_skinning` is the bones of each node, `softness` that of each skin vertex.
    ///
    /// # Errors
    /// [`Error::Invalid`] where a region names what is not there, holds no candidate, or a point of an
    /// exact list lies outside the layer, on a bone, or where a handle already is.
    pub fn place(
        body: &Body,
        node_skinning: &Rows<SkinWeight>,
        softness: &Softness,
        regions: &[HandleRegion],
    ) -> Result<Self> {
        let mut handles = Self::default();
        let mirror = Mirror::of(&body.skin.positions);
        for (r, region) in regions.iter().enumerate() {
            let field = format!("recipe.handles[{r}]");
            let before = handles.positions.len();
            if !(region.soft >= 0.0 && region.soft.is_finite()) {
                let problem = format!("must be 0 (even) or positive, is {}", region.soft);
                return Err(Error::invalid(format!("{field}.soft"), problem));
            }
            let candidates = candidates(body, node_skinning, softness, region, &field)?;
            if candidates.is_empty() {
                let problem = "no soft place lies in this region: widen it, or leave `soft` out";
                return Err(Error::invalid(field, problem));
            }
            let density = match (region.count, region.spacing) {
                (None, None) => None,
                (Some(count), None) if count > 0 => Some(Density::Count(count)),
                (None, Some(spacing)) if spacing > 0.0 => Some(Density::Spacing(spacing)),
                _ => {
                    let problem = "needs a positive count or a positive spacing (m), not both";
                    return Err(Error::invalid(field, problem));
                }
            };
            let positions: Vec<DVec3> = candidates.iter().map(|c| c.position).collect();
            let weights: Vec<f64> = candidates.iter().map(|c| c.weight).collect();
            let taken = &handles.positions;
            let chosen = match (density, mirror) {
                (Some(density), Some(mirror)) if region.soft > 0.0 => {
                    mirrored_farthest_points(mirror, &positions, &weights, taken, density)
                }
                (Some(density), _) => {
                    weighted_farthest_points(&positions, &weights, taken, density)
                }
                (None, _) => (0..candidates.len() as u32).collect(),
            };
            for i in chosen {
                let Candidate { position, row, .. } = &candidates[i as usize];
                if handles.positions.contains(position) {
                    let problem = format!("two handles stand at {position}");
                    return Err(Error::invalid(field, problem));
                }
                handles.positions.push(*position);
                handles.constraints.push(row.iter().copied());
            }
            handles.per_region.push(handles.positions.len() - before);
        }
        if handles.positions.is_empty() {
            return Err(Error::invalid("recipe.handles", "at least one is needed"));
        }
        Ok(handles)
    }
}
