//! The rigid core of a body: what is inside the skin and not tissue, sampled on a grid.

use super::mesh::Grid;
use crate::model::{Body, Surface};
use glam::DVec3;
use std::collections::HashMap;

/// A cell of the core.
pub(super) struct CoreSample {
    pub position: DVec3,
    /// m³.
    pub volume: f64,
    /// The closest node of the layer that a bone holds; node 0 if none does.
    pub nearest_node: u32,
}

/// Cells in the box around the body.
const CELLS: f64 = 5e5;

/// Grid cells whose centre is inside the skin, outside the layer and outside every surface of
/// `known`. Inside is by winding number, so a skin that cuts through itself does no harm; holes are
/// closed by a fan.
pub(super) fn core_samples(body: &Body, known: &[&Surface]) -> Vec<CoreSample> {
    let skin = without_holes(&body.skin);
    let layer = Surface {
        positions: body.layer.mesh.nodes.clone(),
        triangles: body.layer.mesh.boundary_triangles(),
    };
    let positions = || skin.positions.iter().copied();
    let (Some(low), Some(high)) = (
        positions().reduce(DVec3::min),
        positions().reduce(DVec3::max),
    ) else {
        return Vec::new();
    };
    let cell = ((high - low).element_product() / CELLS).cbrt();
    if !(cell > 0.0 && cell.is_finite()) {
        return Vec::new();
    }
    // Off by an odd share of a cell, so that no line runs along an edge of a regular mesh.
    let grid = Grid {
        origin: low + cell * DVec3::new(0.5, 0.4827, 0.4683),
        spacing: cell,
        counts: ((high - low) / cell).to_array().map(|n| n.ceil() as usize),
    };
    let mut core = inside(&grid, &skin);
    for solid in std::iter::once(&layer).chain(known.iter().copied()) {
        let held = inside(&grid, solid);
        core.iter_mut().zip(held).for_each(|(c, h)| *c &= !h);
    }
    let held: Vec<(u32, DVec3)> = (body.layer.bone_of_node.iter().enumerate())
        .filter(|(_, bone)| bone.is_some())
        .map(|(n, _)| (n as u32, body.layer.mesh.nodes[n]))
        .collect();
    let cells: Vec<usize> = (0..core.len()).filter(|&i| core[i]).collect();
    crate::math::par_map(cells.len(), |c| {
        let [nx, ny, _] = grid.counts;
        let (i, j, k) = (cells[c] % nx, cells[c] / nx % ny, cells[c] / (nx * ny));
        let position = grid.origin + cell * DVec3::new(i as f64, j as f64, k as f64);
        let squares = held.iter().map(|(n, q)| (*n, q.distance_squared(position)));
        CoreSample {
            position,
            volume: cell.powi(3),
            nearest_node: (squares.min_by(|a, b| a.1.total_cmp(&b.1))).map_or(0, |n| n.0),
        }
    })
}

/// Which samples of `grid` are inside `surface`, x running fastest.
fn inside(grid: &Grid, surface: &Surface) -> Vec<bool> {
    let nx = grid.counts[0];
    let mut out = vec![false; grid.counts.iter().product()];
    for (line, runs) in grid.inside_runs(surface, 0).iter().enumerate() {
        for &(first, last) in runs {
            out[line * nx + first as usize..=line * nx + last as usize].fill(true);
        }
    }
    out
}

/// `surface` with a fan over every part of its boundary, so that it encloses a volume.
fn without_holes(surface: &Surface) -> Surface {
    let mut edges = HashMap::new();
    for &[a, b, c] in &surface.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((from, to)).or_insert(0i32) += 1;
            *edges.entry((to, from)).or_insert(0i32) -= 1;
        }
    }
    let mut open: Vec<(u32, u32)> = (edges.into_iter())
        .filter(|&(_, n)| n > 0)
        .flat_map(|(edge, n)| (0..n).map(move |_| edge))
        .collect();
    open.sort_unstable();
    // Loops: edges joined by shared vertices.
    let mut parent: HashMap<u32, u32> = open.iter().flat_map(|&(a, b)| [(a, a), (b, b)]).collect();
    fn root(parent: &HashMap<u32, u32>, mut v: u32) -> u32 {
        while parent[&v] != v {
            v = parent[&v];
        }
        v
    }
    for &(a, b) in &open {
        let (a, b) = (root(&parent, a), root(&parent, b));
        parent.insert(a.max(b), a.min(b));
    }
    let mut closed = surface.clone();
    let mut centres = HashMap::<u32, u32>::new();
    for &(a, b) in &open {
        let centre = *centres.entry(root(&parent, a)).or_insert_with_key(|&key| {
            let rim = open.iter().filter(|e| root(&parent, e.0) == key);
            let points: Vec<DVec3> = rim.map(|e| surface.positions[e.0 as usize]).collect();
            let mean = points.iter().sum::<DVec3>() / points.len() as f64;
            closed.positions.push(mean);
            closed.positions.len() as u32 - 1
        });
        closed.triangles.push([b, a, centre]);
    }
    closed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::Limb;

    #[test]
    fn fans_close_the_cut_ends() {
        let skin = Limb::S.body().unwrap().skin;
        assert!(!skin.is_closed());
        let closed = without_holes(&skin);
        assert!(closed.is_closed());
        assert_eq!(closed.positions.len(), skin.positions.len() + 2);
        let again = without_holes(&closed);
        assert_eq!(again.triangles.len(), closed.triangles.len());
    }
}
