//! Where fine handles stand: farthest points of the soft skin, continued after the coarse handles.

use super::recipe::FineRecipe;
use crate::basis::Constraints;
use crate::body::Body;
use crate::handles::candidates::{Candidate, candidates};
use crate::handles::{Density, HandleRegion, Softness, farthest_points};
use glam::DVec3;
use supple::internal::math::Rows;
use supple::model::SkinWeight;
use supple::{Error, Result};

/// Spacing of the fine set relative to the coarse handles'. About a third of a dent's width is enough. At a third of the
/// spacing of 60 handles on a limb (10.7 mm) presses are off by twice to six times as much as at a quarter.
const FINER: f64 = 0.25;
/// More handles are not made: the spacing grows until these suffice.
const MOST: usize = 2000;

/// Where fine handles stand.
pub(super) struct Places {
    pub positions: Vec<DVec3>,
    /// The condition on the nodes that makes U = 1 at each.
    pub constraints: Constraints,
    /// No candidate is farther from a handle, m.
    pub spacing: f64,
}

/// The fine handles of `body` beside those at `coarse`.
///
/// # Errors
/// [`Error::Invalid`] where there is no place for one.
pub(super) fn places(
    body: &Body,
    node_skinning: &Rows<SkinWeight>,
    softness: &Softness,
    coarse: &[DVec3],
    recipe: &FineRecipe,
) -> Result<Places> {
    let field = "recipe.fine_handles";
    // What is stiff has no weight, and the rest counts alike.
    let soft = HandleRegion {
        soft: 1.0,
        ..HandleRegion::default()
    };
    let candidates = candidates(body, node_skinning, softness, &soft, field)?;
    let spacing = recipe.spacing.unwrap_or(FINER * median_gap(coarse));
    let mut spacing = spacing.max(embedded_edge(body));
    let places: Vec<DVec3> = candidates.iter().map(|c| c.position).collect();
    let mut chosen = farthest_points(&places, coarse, Density::Spacing(spacing));
    if chosen.len() > MOST {
        let next = places[chosen[MOST] as usize];
        chosen.truncate(MOST);
        let before = chosen.iter().map(|&i| places[i as usize]);
        let gaps = coarse.iter().copied().chain(before);
        spacing = gaps.map(|p| p.distance(next)).fold(f64::INFINITY, f64::min);
    }
    if chosen.is_empty() {
        let problem = format!(
            "no soft skin is farther than {spacing} m from a coarse handle; ask for a smaller spacing, or leave them out"
        );
        return Err(Error::invalid(field, problem));
    }
    let chosen: Vec<&Candidate> = chosen.iter().map(|&i| &candidates[i as usize]).collect();
    Ok(Places {
        positions: chosen.iter().map(|c| c.position).collect(),
        constraints: chosen.iter().map(|c| c.row.iter().copied()).collect(),
        spacing,
    })
}

/// Median over `places` of the distance to the nearest other one, m; ∞ of a single one.
fn median_gap(places: &[DVec3]) -> f64 {
    let gap = |h: usize| {
        let others = (0..places.len()).filter(|o| *o != h);
        let gaps = others.map(|o| places[o].distance(places[h]));
        gaps.fold(f64::INFINITY, f64::min)
    };
    let mut gaps: Vec<f64> = (0..places.len()).map(gap).collect();
    gaps.sort_by(f64::total_cmp);
    gaps.get(gaps.len() / 2).copied().unwrap_or(f64::INFINITY)
}

/// Mean edge of the tets that skin vertices lie inside, m: closer handles would share them. 0 where the mesh meets the skin.
fn embedded_edge(body: &Body) -> f64 {
    let mesh = &body.layer.mesh;
    let inside = body.layer.skin_embedding.iter().filter(|row| row.len() > 1);
    let (mut sum, mut count) = (0.0, 0);
    for row in inside {
        for (i, a) in row.iter().enumerate() {
            for b in &row[..i] {
                sum += mesh.nodes[a.0 as usize].distance(mesh.nodes[b.0 as usize]);
                count += 1;
            }
        }
    }
    if count == 0 {
        0.0
    } else {
        sum / f64::from(count)
    }
}
