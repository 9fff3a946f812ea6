//! Which lattice nodes a bone holds: those inside it, and those within a quarter cell of it.

use super::bcc::BccLattice;
use super::scanlines::Grid;
use crate::math::closest_point;
use glam::DVec3;
use std::collections::BTreeMap;
use supple::model::Surface;

/// The bones that reach each node, the nearest first; inside counts as nearest.
pub(super) fn bones_of_nodes(lattice: &BccLattice, bones: &[Surface]) -> BTreeMap<u32, Vec<u32>> {
    let reach = 0.25 * lattice.cell;
    // (node, bone) → distance, 0 inside.
    let mut distances: BTreeMap<(u32, u32), f64> = BTreeMap::new();
    for (bone, surface) in bones.iter().enumerate() {
        let bone = bone as u32;
        for (centred, shift) in [(false, 0.0), (true, 0.5)] {
            let grid = Grid {
                origin: lattice.origin + shift * lattice.cell,
                spacing: lattice.cell,
                counts: lattice.counts.map(|n| n + usize::from(!centred)),
            };
            let node = |at: [usize; 3]| {
                if centred {
                    lattice.centre_node(at)
                } else {
                    lattice.corner_node(at)
                }
            };
            for (line, runs) in grid.inside_runs(surface, 0).iter().enumerate() {
                let (j, k) = (line % grid.counts[1], line / grid.counts[1]);
                for i in runs.iter().flat_map(|&(from, to)| from..=to) {
                    distances.insert((node([i as usize, j, k]), bone), 0.0);
                }
            }
        }
        for (node, (offset, _)) in nodes_near(lattice, surface, reach) {
            let known = distances.entry((node, bone)).or_insert(f64::INFINITY);
            *known = known.min(offset.length());
        }
    }
    let mut nearest: BTreeMap<u32, Vec<(f64, u32)>> = BTreeMap::new();
    for ((node, bone), distance) in distances {
        nearest.entry(node).or_default().push((distance, bone));
    }
    nearest
        .into_iter()
        .map(|(node, mut bones)| {
            bones.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            (node, bones.into_iter().map(|(_, bone)| bone).collect())
        })
        .collect()
}

/// The nodes within `reach` of a surface: the way to each from the closest place of it, and the normal there.
pub(super) fn nodes_near(
    lattice: &BccLattice,
    surface: &Surface,
    reach: f64,
) -> BTreeMap<u32, (DVec3, DVec3)> {
    let mut near: BTreeMap<u32, (DVec3, DVec3)> = BTreeMap::new();
    for (t, centred) in (0..surface.triangles.len()).flat_map(|t| [(t, false), (t, true)]) {
        let corners = surface.corners(t);
        let low = corners.into_iter().fold(DVec3::INFINITY, DVec3::min) - reach;
        let high = corners.into_iter().fold(DVec3::NEG_INFINITY, DVec3::max) + reach;
        let shift = if centred { 0.5 } else { 0.0 };
        let steps = |p: DVec3| ((p - lattice.origin) / lattice.cell - shift).to_array();
        let (first, last) = (steps(low), steps(high));
        let range = |a: usize| {
            let count = lattice.counts[a] + usize::from(!centred);
            let end = (last[a].floor() + 1.0).clamp(0.0, count as f64) as usize;
            (first[a].ceil().max(0.0) as usize).min(end)..end
        };
        for (k, j) in range(2).flat_map(|k| range(1).map(move |j| (k, j))) {
            for i in range(0) {
                let node = if centred {
                    lattice.centre_node([i, j, k])
                } else {
                    lattice.corner_node([i, j, k])
                };
                let place = lattice.node_position(node);
                let offset = place - closest_point(place, &corners);
                let nearer = |known: &(DVec3, DVec3)| offset.length() < known.0.length();
                if offset.length() <= reach && near.get(&node).is_none_or(nearer) {
                    near.insert(node, (offset, surface.area_vector(t).normalize_or_zero()));
                }
            }
        }
    }
    near
}
