//! Welding: vertices that a file splits for texture coordinates or normals are one for the physics.

use crate::model::SkinWeight;
use glam::{DVec3, I64Vec3};
use std::collections::HashMap;

/// Vertices nearer to each other than this are one, relative to the largest extent of all.
const POSITION_TOLERANCE: f64 = 1e-6;

/// Displacements of one shape may differ by this, relative to the largest extent.
const SHAPE_TOLERANCE: f64 = 1e-5;

/// And Σ |w − w'| may be this.
const WEIGHT_TOLERANCE: f64 = 1e-3;

/// Vertices before welding.
pub(super) struct Vertices<'a> {
    pub positions: &'a [DVec3],
    pub skinning: &'a [Vec<SkinWeight>],
    /// For each vertex the shapes that move it, rising, with the displacement.
    pub shapes: &'a [Vec<(u32, DVec3)>],
}

/// For each vertex the first one that is the same: in the same place, moved by the same bones with the
/// same weights and by the same shapes. (Lips that touch differ in shapes or weights and stay apart.)
/// Every second value: how many there are after it.
pub(super) fn weld(vertices: &Vertices<'_>) -> (Vec<u32>, usize) {
    let positions = vertices.positions;
    let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = (positions.iter().copied()).fold(DVec3::NEG_INFINITY, DVec3::max);
    let extent = (high - low).max_element().max(f64::MIN_POSITIVE);
    let tolerance = POSITION_TOLERANCE * extent;
    // A cell of twice the tolerance: what is near lies in the cell or next to it.
    let cell = |p: DVec3| ((p - low) / (2.0 * tolerance)).floor().as_i64vec3();
    let same = |a: usize, b: usize| {
        positions[a].distance(positions[b]) <= tolerance
            && weight_distance(&vertices.skinning[a], &vertices.skinning[b]) <= WEIGHT_TOLERANCE
            && shape_distance(&vertices.shapes[a], &vertices.shapes[b]) <= SHAPE_TOLERANCE * extent
    };
    let mut cells: HashMap<I64Vec3, Vec<u32>> = HashMap::new();
    let mut number: Vec<u32> = Vec::with_capacity(positions.len());
    let mut count = 0;
    for v in 0..positions.len() {
        let own = cell(positions[v]);
        let around = (0..27).map(|k| own + I64Vec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
        let near = around.filter_map(|c| cells.get(&c)).flatten();
        let first = near.copied().filter(|&u| same(u as usize, v)).min();
        number.push(match first {
            Some(u) => number[u as usize],
            None => {
                cells.entry(own).or_default().push(v as u32);
                count += 1;
                count - 1
            }
        });
    }
    (number, count as usize)
}

/// Σ |w − w'|.
fn weight_distance(a: &[SkinWeight], b: &[SkinWeight]) -> f64 {
    let weight = |row: &[SkinWeight], bone| {
        let found = row.iter().find(|w| w.bone == bone);
        found.map_or(0.0, |w| w.weight)
    };
    let both: f64 = (a.iter())
        .map(|w| (w.weight - weight(b, w.bone)).abs())
        .sum();
    let only_b = b.iter().filter(|w| a.iter().all(|v| v.bone != w.bone));
    both + only_b.map(|w| w.weight).sum::<f64>()
}

/// The largest difference of a shape's displacement.
fn shape_distance(a: &[(u32, DVec3)], b: &[(u32, DVec3)]) -> f64 {
    let other = |row: &[(u32, DVec3)], shape: u32| {
        let found = row.binary_search_by_key(&shape, |s| s.0);
        found.map_or(DVec3::ZERO, |at| row[at].1)
    };
    let difference = |(shape, d): &(u32, DVec3), row| (*d - other(row, *shape)).length();
    let (ab, ba) = (
        a.iter().map(|s| difference(s, b)),
        b.iter().map(|s| difference(s, a)),
    );
    ab.chain(ba).fold(0.0, f64::max)
}
