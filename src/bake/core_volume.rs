//! The rigid core of a body: what is inside the skin and not tissue, sampled on a grid.

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
/// `known`. Inside is a winding number counted along rays in x, so a skin that cuts through itself
/// does no harm; holes are closed by a fan.
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
    let grid = Grid::new(low, high, cell);
    let skin_crossings = grid.crossings(&skin);
    let mut solid = grid.crossings(&layer);
    for surface in known {
        let bone = grid.crossings(surface);
        solid.iter_mut().zip(bone).for_each(|(s, b)| s.extend(b));
    }
    let held: Vec<(u32, DVec3)> = (body.layer.bone_of_node.iter().enumerate())
        .filter(|(_, bone)| bone.is_some())
        .map(|(n, _)| (n as u32, body.layer.mesh.nodes[n]))
        .collect();
    let columns = crate::math::par_map(grid.rays(), |ray| {
        let inside = |crossings: &[(f64, i32)], x: f64| {
            crossings
                .iter()
                .filter(|c| c.0 < x)
                .map(|c| c.1)
                .sum::<i32>()
                > 0
        };
        (0..grid.count[0])
            .map(|i| grid.centre(i, ray))
            .filter(|p| inside(&skin_crossings[ray], p.x) && !inside(&solid[ray], p.x))
            .map(|position| {
                let squares = held.iter().map(|(n, q)| (*n, q.distance_squared(position)));
                CoreSample {
                    position,
                    volume: cell.powi(3),
                    nearest_node: squares
                        .min_by(|a, b| a.1.total_cmp(&b.1))
                        .map_or(0, |n| n.0),
                }
            })
            .collect::<Vec<_>>()
    });
    columns.into_iter().flatten().collect()
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

/// Rays along x through a grid of cell centres.
struct Grid {
    origin: DVec3,
    cell: f64,
    count: [usize; 3],
}

impl Grid {
    fn new(low: DVec3, high: DVec3, cell: f64) -> Self {
        let size = high - low;
        Self {
            // Off by an odd share of a cell, so that no ray runs along an edge of a regular mesh.
            origin: low - cell * DVec3::new(0.0, 0.0173, 0.0317),
            cell,
            count: [size.x, size.y, size.z].map(|s| (s / cell).ceil() as usize + 1),
        }
    }

    fn rays(&self) -> usize {
        self.count[1] * self.count[2]
    }

    fn centre(&self, i: usize, ray: usize) -> DVec3 {
        let (j, k) = (ray % self.count[1], ray / self.count[1]);
        let index = DVec3::new(i as f64, j as f64, k as f64);
        self.origin + self.cell * (index + 0.5)
    }

    /// Where each ray crosses `surface`, with +1 going in and −1 going out.
    fn crossings(&self, surface: &Surface) -> Vec<Vec<(f64, i32)>> {
        let mut out = vec![Vec::new(); self.rays()];
        for t in 0..surface.triangles.len() {
            let [a, b, c] = surface.corners(t);
            // Twice the area as seen along x; its sign says which way the ray goes.
            let area = (b.y - a.y) * (c.z - a.z) - (b.z - a.z) * (c.y - a.y);
            if area == 0.0 || !area.is_finite() {
                continue;
            }
            let range = |values: [f64; 3], origin: f64, count: usize| {
                let low = values.into_iter().fold(f64::INFINITY, f64::min);
                let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
                let first = ((low - origin) / self.cell - 0.5).ceil().max(0.0) as usize;
                let end = ((high - origin) / self.cell - 0.5).floor() + 1.0;
                first..(end.max(0.0) as usize).min(count)
            };
            for k in range([a.z, b.z, c.z], self.origin.z, self.count[2]) {
                for j in range([a.y, b.y, c.y], self.origin.y, self.count[1]) {
                    let ray = j + k * self.count[1];
                    let p = self.centre(0, ray);
                    let edge = |u: DVec3, v: DVec3| {
                        ((v.y - u.y) * (p.z - u.z) - (v.z - u.z) * (p.y - u.y)) / area
                    };
                    let (wa, wb, wc) = (edge(b, c), edge(c, a), edge(a, b));
                    if wa >= 0.0 && wb >= 0.0 && wc >= 0.0 {
                        let x = wa * a.x + wb * b.x + wc * c.x;
                        out[ray].push((x, if area < 0.0 { 1 } else { -1 }));
                    }
                }
            }
        }
        out
    }
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
