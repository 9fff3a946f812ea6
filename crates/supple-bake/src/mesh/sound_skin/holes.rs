//! Caps over the holes.

use super::edges::edges;
use crate::mesh::disjoint_sets::DisjointSets;
use crate::mesh::report::{Hole, SkinReport};
use glam::DVec3;
use std::collections::BTreeMap;
use supple::model::Surface;

/// Adds a cap, triangles around a middle vertex, over every part of the boundary, so that the surface encloses a volume; returns the
/// rims.
pub(super) fn close_holes(
    surface: &mut Surface,
    held: &mut [bool],
    report: &mut SkinReport,
) -> Vec<Vec<u32>> {
    // Edges that run one way more often than the other, once for each time.
    let mut open: Vec<(u32, u32)> = Vec::new();
    for (&(a, b), sides) in &edges(&surface.triangles) {
        let along = sides.iter().filter(|s| s.1).count();
        let against = sides.len() - along;
        open.extend(std::iter::repeat_n((a, b), along.saturating_sub(against)));
        open.extend(std::iter::repeat_n((b, a), against.saturating_sub(along)));
    }
    let mut sets = DisjointSets::new(surface.positions.len());
    open.iter().for_each(|&(a, b)| sets.union(a, b));
    let mut loops: BTreeMap<u32, Vec<(u32, u32)>> = BTreeMap::new();
    for &(a, b) in &open {
        loops.entry(sets.find(a)).or_default().push((a, b));
    }
    let place = |surface: &Surface, v: u32| surface.positions[v as usize];
    let mut rims = Vec::new();
    for rim in loops.values() {
        let middle = rim.iter().map(|e| place(surface, e.0)).sum::<DVec3>() / rim.len() as f64;
        let lengths = rim
            .iter()
            .map(|&(a, b)| place(surface, a).distance(place(surface, b)));
        report.holes.push(Hole {
            edges: rim.len(),
            perimeter: lengths.sum(),
            place: middle.to_array(),
        });
        let centre = surface.positions.len() as u32;
        surface.positions.push(middle);
        for &(a, b) in rim {
            surface.triangles.push([b, a, centre]);
            held[a as usize] = true;
            held[b as usize] = true;
        }
        rims.push(rim.iter().map(|e| e.0).collect());
    }
    rims
}
