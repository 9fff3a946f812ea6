//! Welding: vertices that a file splits are one for the physics.
//!
//! Vertices are one if they lie in the same place (to 1e-6 of the largest extent), move with the same
//! shapes and have the same skin weights (to 1e-5 in all). So are, for the tissue alone, vertices on the
//! rims of cuts whose weights differ by up to 0.25: they keep weights of their own where they are drawn.

use glam::{DVec3, I64Vec3};
use std::collections::HashMap;
use supple::model::SkinWeight;

/// Vertices nearer to each other than this are one, relative to the largest extent of all.
const POSITION_TOLERANCE: f64 = 1e-6;

/// Displacements of one shape may differ by this, relative to the largest extent.
const SHAPE_TOLERANCE: f64 = 1e-5;

/// Σ |w − w'| of vertices that a file draws as one.
pub(super) const DRAWN_WEIGHTS: f64 = 1e-5;

/// Σ |w − w'| of vertices on both sides of a cut that the tissue closes.
pub(super) const CUT_WEIGHTS: f64 = 0.25;

/// Vertices before welding.
pub(super) struct Vertices<'a> {
    pub positions: &'a [DVec3],
    pub skinning: &'a [Vec<SkinWeight>],
    /// For each vertex the shapes that move it, rising, with the displacement.
    pub shapes: &'a [Vec<(u32, DVec3)>],
}

impl Vertices<'_> {
    /// For each vertex the lowest one that is the same: in the same place, moved by the same shapes, and
    /// by the same bones with weights that differ by `weight_tolerance` in all. Vertices for which
    /// `joins` is false are the same as none. (Lips that touch differ in shapes or weights and stay apart.)
    pub fn same(&self, weight_tolerance: f64, joins: impl Fn(usize) -> bool) -> Vec<u32> {
        let positions = self.positions;
        let low = positions.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = (positions.iter().copied()).fold(DVec3::NEG_INFINITY, DVec3::max);
        let extent = (high - low).max_element().max(f64::MIN_POSITIVE);
        let tolerance = POSITION_TOLERANCE * extent;
        // A cell of twice the tolerance: what is near lies in the cell or next to it.
        let cell = |p: DVec3| ((p - low) / (2.0 * tolerance)).floor().as_i64vec3();
        let same = |a: usize, b: usize| {
            positions[a].distance(positions[b]) <= tolerance
                && weight_distance(&self.skinning[a], &self.skinning[b]) <= weight_tolerance
                && shape_distance(&self.shapes[a], &self.shapes[b]) <= SHAPE_TOLERANCE * extent
        };
        let mut cells: HashMap<I64Vec3, Vec<u32>> = HashMap::new();
        let mut first: Vec<u32> = (0..positions.len() as u32).collect();
        for v in (0..positions.len()).filter(|&v| joins(v)) {
            let own = cell(positions[v]);
            let around = (0..27).map(|k| own + I64Vec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
            let near = around.filter_map(|c| cells.get(&c)).flatten();
            match near.copied().filter(|&u| same(u as usize, v)).min() {
                Some(u) => first[v] = u,
                None => cells.entry(own).or_default().push(v as u32),
            }
        }
        first
    }
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
