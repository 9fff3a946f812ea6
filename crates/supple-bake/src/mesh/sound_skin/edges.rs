//! The triangles around edges, and what they say: where a surface is no manifold, and its parts.

use crate::mesh::disjoint_sets::DisjointSets;
use crate::mesh::report::SkinReport;
use std::collections::{BTreeMap, HashSet};
use supple::model::Surface;

/// The triangles at each edge (smaller vertex first), each with whether it runs along it.
pub(super) fn edges(triangles: &[[u32; 3]]) -> BTreeMap<(u32, u32), Vec<(u32, bool)>> {
    let mut edges: BTreeMap<(u32, u32), Vec<(u32, bool)>> = BTreeMap::new();
    for (t, &[a, b, c]) in triangles.iter().enumerate() {
        for (u, v) in [(a, b), (b, c), (c, a)] {
            let sides = edges.entry((u.min(v), u.max(v))).or_default();
            sides.push((t as u32, u < v));
        }
    }
    edges
}

/// Holds the ends of edges that have more than two triangles, or two that still run the same way.
pub(super) fn mark_non_manifold(surface: &Surface, held: &mut [bool], report: &mut SkinReport) {
    for (&(a, b), sides) in &edges(&surface.triangles) {
        let sound = match sides.as_slice() {
            [_] => true,
            [s, t] => s.1 != t.1,
            _ => false,
        };
        if !sound {
            report.non_manifold_edges += 1;
            held[a as usize] = true;
            held[b as usize] = true;
        }
    }
}

/// The part of each vertex: vertices that triangles join.
pub(super) fn parts(surface: &Surface, report: &mut SkinReport) -> Vec<u32> {
    let mut sets = DisjointSets::new(surface.positions.len());
    for &[a, b, c] in &surface.triangles {
        sets.union(a, b);
        sets.union(b, c);
    }
    let part: Vec<u32> = (0..surface.positions.len() as u32)
        .map(|v| sets.find(v))
        .collect();
    let named: HashSet<u32> = (surface.triangles.iter())
        .map(|t| part[t[0] as usize])
        .collect();
    report.parts = named.len();
    part
}
