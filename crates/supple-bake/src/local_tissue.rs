//! What the material has of its own in each tet: its stiffness, by region, and its axes.
//!
//! The axes follow the body's own directions. The skin's normal is carried into the depth harmonically, held on the
//! skin and, on a bone, at the normal of the skin nearest to it; the second axis is the bone's direction (joint to
//! child joints, blended by the tet's skin weights) made orthogonal to it, the third runs around the bone.

use super::interior::InteriorField;
use super::recipe::Recipe;
use crate::body::Body;
use crate::math::NearestPoint;
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use supple::internal::math::{Rows, par_map, symmetric_eigen};
use supple::material::LocalTissue;
use supple::model::{Skeleton, SkinWeight};
use supple::{Error, Result};

/// A part of the stiffness map: tissue that satisfies every key that is given is `scale` times as stiff. Where it does so
/// in part (between two bones, where a painted map fades), the factor is scale^w with w the share, so that soft and stiff
/// blend alike. Regions multiply.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StiffnessRegion {
    /// The factor; positive.
    pub scale: f64,
    /// Only what follows these bones: the share is the sum of their skin weights. None named: everything.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bones: Vec<String>,
    /// Only inside this box: lowest and highest corner in the reference shape, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within: Option<[[f64; 3]; 2]>,
    /// The share is the body's map of this name ([`Body::painted`]), carried into the depth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub painted: Option<String>,
}

impl StiffnessRegion {
    /// Checks the numbers; `field` names the region in errors.
    ///
    /// # Errors
    /// [`Error::Invalid`].
    pub fn validate(&self, field: &str) -> Result<()> {
        let scale = self.scale;
        if scale > 0.0 && scale.is_finite() {
            return Ok(());
        }
        let problem = format!("must be positive, is {scale}");
        Err(Error::invalid(format!("{field}.scale"), problem))
    }
}

/// Stiffness and axes of each tet of a meshed `body`, and the share in it of each of the recipe's softness regions.
///
/// # Errors
/// [`Error::Invalid`] where a region names a bone or a map that is not there.
pub(crate) fn local_tissue(
    body: &Body,
    field: &InteriorField<'_>,
    node_skinning: &Rows<SkinWeight>,
    recipe: &Recipe,
) -> Result<(Vec<LocalTissue>, Vec<Vec<f64>>)> {
    let layer = &body.layer;
    let stiffness = recipe.stiffness.iter().enumerate();
    let stiffness = stiffness.map(|(r, region)| Selection {
        bones: &region.bones,
        within: region.within,
        painted: region.painted.as_deref(),
        field: format!("recipe.stiffness[{r}]"),
    });
    let softness = recipe.softness.iter().enumerate();
    let softness = softness.map(|(r, region)| Selection {
        bones: &region.bones,
        within: region.within,
        painted: region.painted.as_deref(),
        field: format!("recipe.softness[{r}]"),
    });
    let selections: Vec<Selection<'_>> = stiffness.chain(softness).collect();
    let maps = painted_maps(body, &selections)?;
    let normals = body.skin.vertex_normals();
    let search = NearestPoint::new(&body.skin.positions);
    let nearest = par_map(layer.mesh.nodes.len(), |n| {
        let held = layer.bone_of_node[n].is_some();
        let found = held.then(|| search.nearest(layer.mesh.nodes[n])).flatten();
        found.map_or(0, |(v, _)| v)
    });
    // Fields 0 to 2 are the normal, then the maps.
    let on_skin = |k: usize, v: u32| match k.checked_sub(3) {
        None => normals[v as usize][k],
        Some(map) => maps[map].1[v as usize],
    };
    let on_bone = |k: usize, node: u32, _: u32| on_skin(k, nearest[node as usize]);
    let fields = field.extend_from(3 + maps.len(), on_skin, on_bone, |_, u| u.to_vec());
    let mean = |k: usize, t: usize| {
        let nodes = layer.mesh.tets[t].iter();
        nodes.map(|&n| fields[k][n as usize]).sum::<f64>() / 4.0
    };
    let shares = (selections.iter())
        .map(|selection| Share::new(body, &maps, selection))
        .collect::<Result<Vec<_>>>()?;
    let along = bone_directions(&body.skeleton, body);
    let of_tets = par_map(layer.mesh.tets.len(), |t| {
        let weights = layer.mesh.tets[t].map(|n| node_skinning.row(n as usize));
        let of_bones = |value: &dyn Fn(u32) -> f64| {
            let entries = weights.iter().flat_map(|row| row.iter());
            entries.map(|w| w.weight * value(w.bone)).sum::<f64>() / 4.0
        };
        let direction = DVec3::from_array(std::array::from_fn(|axis| {
            of_bones(&|bone| along[bone as usize][axis])
        }));
        let shares: Vec<f64> = (shares.iter())
            .map(|share| {
                let map = share.map.map_or(1.0, |m| mean(3 + m, t));
                let bones = share.bones.as_ref();
                let bones = bones.map_or(1.0, |own| of_bones(&|b| f64::from(own.contains(&b))));
                let inside = share.contains(layer.mesh.centroid(t));
                f64::from(inside) * bones * map
            })
            .collect();
        let exponents = recipe.stiffness.iter().zip(&shares);
        let exponent: f64 = exponents
            .map(|(region, share)| share * region.scale.ln())
            .sum();
        let tissue = LocalTissue {
            stiffness: exponent.exp(),
            axes: axes(DVec3::new(mean(0, t), mean(1, t), mean(2, t)), direction),
            ..LocalTissue::default()
        };
        (tissue, shares)
    });
    let (first, count) = (recipe.stiffness.len(), recipe.softness.len());
    let of_region = |r: usize| {
        let shares = of_tets
            .iter()
            .map(|(_, shares)| shares[first + r].clamp(0.0, 1.0));
        shares.collect()
    };
    let selected = (0..count).map(of_region).collect();
    Ok((
        of_tets.into_iter().map(|(tissue, _)| tissue).collect(),
        selected,
    ))
}

/// Where a region of a recipe is.
struct Selection<'a> {
    bones: &'a [String],
    within: Option<[[f64; 3]; 2]>,
    painted: Option<&'a str>,
    /// The region's name in errors.
    field: String,
}

/// A region whose names are looked up.
struct Share {
    bones: Option<Vec<u32>>,
    within: Option<[DVec3; 2]>,
    /// Which of the painted maps.
    map: Option<usize>,
}

impl Share {
    fn new(body: &Body, maps: &[(&str, &[f64])], selection: &Selection<'_>) -> Result<Self> {
        let field = format!("{}.bones", selection.field);
        let bones = body.skeleton.named(selection.bones, &field)?;
        Ok(Self {
            bones: (!bones.is_empty()).then_some(bones),
            within: (selection.within).map(|corners| corners.map(DVec3::from_array)),
            map: (selection.painted)
                .and_then(|name| maps.iter().position(|(known, _)| *known == name)),
        })
    }

    fn contains(&self, p: DVec3) -> bool {
        self.within
            .is_none_or(|[low, high]| p.cmpge(low).all() && p.cmple(high).all())
    }
}

/// Each map that a region names, once.
fn painted_maps<'a>(
    body: &'a Body,
    selections: &[Selection<'a>],
) -> Result<Vec<(&'a str, &'a [f64])>> {
    let mut maps = BTreeMap::new();
    for selection in selections {
        if let Some(name) = selection.painted {
            let map = body.painted_map(name, &format!("{}.painted", selection.field))?;
            maps.insert(name, map);
        }
    }
    Ok(maps.into_iter().collect())
}

/// The rotation whose first axis is `normal` and whose second is as near to `along` as can be.
fn axes(normal: DVec3, along: DVec3) -> DQuat {
    let x = normal.try_normalize().unwrap_or(DVec3::X);
    let across = along - x * x.dot(along);
    // Where the bone points at the skin, no direction in its plane is its own.
    let y = if across.length() > 1e-3 * along.length() {
        across.try_normalize()
    } else {
        None
    };
    let y = y.unwrap_or_else(|| x.any_orthonormal_vector());
    DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))).normalize()
}

/// The direction of each bone: from its joint to the mean of its children's, of a last one from its parent's joint; a
/// bone alone lies along the longest axis of the skin.
fn bone_directions(skeleton: &Skeleton, body: &Body) -> Vec<DVec3> {
    let mut to_children = vec![DVec3::ZERO; skeleton.len()];
    for (j, parent) in skeleton.parents.iter().enumerate() {
        if let Some(p) = parent {
            to_children[*p as usize] += skeleton.joints[j] - skeleton.joints[*p as usize];
        }
    }
    let alone = longest_axis(&body.skin.positions);
    (0..skeleton.len())
        .map(|j| {
            let from_parent =
                skeleton.parents[j].map(|p| skeleton.joints[j] - skeleton.joints[p as usize]);
            (to_children[j].try_normalize())
                .or(from_parent.and_then(DVec3::try_normalize))
                .unwrap_or(alone)
        })
        .collect()
}

/// The direction in which `points` spread most.
fn longest_axis(points: &[DVec3]) -> DVec3 {
    let centre = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let spread = |p: &DVec3| {
        let d = *p - centre;
        DMat3::from_cols(d * d.x, d * d.y, d * d.z)
    };
    let (values, vectors) = symmetric_eigen(points.iter().map(spread).sum());
    let largest = (0..3).max_by(|&i, &j| values[i].total_cmp(&values[j]));
    vectors.col(largest.unwrap_or(0))
}
