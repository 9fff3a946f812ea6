//! One vertex where a seam doubles it, and each triangle once.

use super::edges::edges;
use crate::mesh::bone_axes::extent;
use crate::mesh::report::SkinReport;
use std::collections::{HashMap, HashSet};
use supple::model::Surface;

/// Vertices of a seam lie no farther apart than about this, relative to the skin's extent.
const SEAM: f64 = 1e-6;

/// A triangle thinner than this, relative to its longest edge squared, has no area.
const LEAST_AREA: f64 = 1e-9;

/// Joins vertices of the border that lie in the same place: a seam between parts that follow their bones
/// differently. Each vertex with the one that stands for it.
pub(super) fn stitch(skin: &Surface, report: &mut SkinReport) -> Vec<u32> {
    let mut border = vec![false; skin.positions.len()];
    for (&(a, b), sides) in &edges(&skin.triangles) {
        if sides.len() == 1 {
            border[a as usize] = true;
            border[b as usize] = true;
        }
    }
    let cell = SEAM * extent(skin);
    let key = |v: usize| {
        (skin.positions[v] / cell)
            .round()
            .to_array()
            .map(|x| x as i64)
    };
    let mut first: HashMap<[i64; 3], u32> = HashMap::new();
    let stands_for: Vec<u32> = (0..border.len())
        .map(|v| match border[v] && cell > 0.0 {
            true => *first.entry(key(v)).or_insert(v as u32),
            false => v as u32,
        })
        .collect();
    report.stitched_vertices = (stands_for.iter().zip(0..))
        .filter(|&(&first, v)| first != v)
        .count();
    stands_for
}

/// Indices of the triangles with three corners, each set of corners once. A needle without area
/// stays, for its neighbours' sake.
pub(super) fn distinct_triangles(
    skin: &Surface,
    stands_for: &[u32],
    report: &mut SkinReport,
) -> Vec<usize> {
    let mut seen = HashSet::new();
    let mut used = vec![false; skin.positions.len()];
    let mut kept = Vec::with_capacity(skin.triangles.len());
    for (t, &[a, b, c]) in skin.triangles.iter().enumerate() {
        let [p, q, r] = skin.corners(t);
        let longest = (p - q).length_squared().max((q - r).length_squared());
        let longest = longest.max((r - p).length_squared());
        if skin.area_vector(t).length() <= LEAST_AREA * longest {
            report.degenerate_triangles += 1;
        }
        if a == b || b == c || c == a {
            continue;
        }
        let mut corners = [a, b, c];
        corners.sort_unstable();
        if seen.insert(corners) {
            kept.push(t);
            corners.iter().for_each(|&v| used[v as usize] = true);
        } else {
            report.duplicate_triangles += 1;
        }
    }
    let used = stands_for.iter().filter(|&&v| used[v as usize]).count();
    report.isolated_vertices = stands_for.len() - used;
    kept
}
