//! What tests ask of a closed triangle surface.
#![allow(dead_code)] // each test uses some of it

use std::collections::{BTreeMap, BTreeSet};
use supple::glam::DVec3;
use supple::model::{SkinWeight, Surface};
use supple_bake::ParametricModel;

/// Undirected edges, each once.
pub fn edges(triangles: &[[u32; 3]]) -> BTreeSet<(u32, u32)> {
    let directed = triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    directed.map(|(a, b)| (a.min(b), a.max(b))).collect()
}

/// Whether the triangles around every vertex form one ring.
pub fn is_manifold(surface: &Surface) -> bool {
    let mut next = vec![BTreeMap::new(); surface.positions.len()];
    for &[a, b, c] in &surface.triangles {
        for (v, from, to) in [(a, b, c), (b, c, a), (c, a, b)] {
            next[v as usize].insert(from, to);
        }
    }
    next.iter().all(|ring| {
        let Some(&start) = ring.keys().next() else {
            return false;
        };
        let (mut at, mut steps) = (start, 0);
        loop {
            at = match ring.get(&at) {
                Some(&to) => to,
                None => return false,
            };
            steps += 1;
            if at == start || steps > ring.len() {
                return at == start && steps == ring.len();
            }
        }
    })
}

/// Number of connected components.
pub fn components(surface: &Surface) -> usize {
    let mut label: Vec<usize> = (0..surface.positions.len()).collect();
    fn root(label: &mut [usize], mut v: usize) -> usize {
        while label[v] != v {
            label[v] = label[label[v]];
            v = label[v];
        }
        v
    }
    for t in &surface.triangles {
        let r = t.map(|v| root(&mut label, v as usize));
        label[r[1]] = r[0];
        let r = t.map(|v| root(&mut label, v as usize));
        label[r[2]] = r[0];
    }
    (0..label.len()).filter(|&v| label[v] == v).count()
}

/// Solid angle of the triangle seen from `p`, over 4π (van Oosterom and Strackee 1983).
pub fn winding_number(p: DVec3, surface: &Surface) -> f64 {
    let angle: f64 = (0..surface.triangles.len())
        .map(|t| {
            let [a, b, c] = surface.corners(t).map(|q| q - p);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            2.0 * a.dot(b.cross(c)).atan2(denominator)
        })
        .sum();
    angle / (4.0 * std::f64::consts::PI)
}

/// Distance from `p` to a triangle (Ericson, Real-Time Collision Detection, 5.1.5).
pub fn distance_to_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let on_segment = |a: DVec3, b: DVec3| {
        let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        p.distance(a + t * (b - a))
    };
    let n = (b - a).cross(c - a);
    let inside = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|&(u, v)| n.dot((v - u).cross(p - u)) >= 0.0);
    if inside {
        return (p - a).dot(n.normalize()).abs();
    }
    on_segment(a, b).min(on_segment(b, c)).min(on_segment(c, a))
}

/// Where the segment from `from` along `way` passes through the triangle, as a fraction of `way`.
pub fn crossing(from: DVec3, way: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (u, v) = (b - a, c - a);
    let p = way.cross(v);
    let determinant = u.dot(p);
    if determinant.abs() < 1e-30 {
        return None;
    }
    let offset = from - a;
    let s = offset.dot(p) / determinant;
    let q = offset.cross(u);
    let t = way.dot(q) / determinant;
    let hit = v.dot(q) / determinant;
    (s >= 0.0 && t >= 0.0 && s + t <= 1.0 && (0.0..=1.0).contains(&hit)).then_some(hit)
}

/// Triangles by the cells of a grid that their boxes touch.
pub struct Grid {
    cell: f64,
    cells: BTreeMap<[i32; 3], Vec<usize>>,
}

impl Grid {
    pub fn new(surface: &Surface, cell: f64) -> Self {
        let mut cells: BTreeMap<[i32; 3], Vec<usize>> = BTreeMap::new();
        for t in 0..surface.triangles.len() {
            for key in Self::touched(&surface.corners(t), cell) {
                cells.entry(key).or_default().push(t);
            }
        }
        Self { cell, cells }
    }

    fn touched(points: &[DVec3], cell: f64) -> Vec<[i32; 3]> {
        let low = points.iter().fold(DVec3::MAX, |a, b| a.min(*b)) / cell;
        let high = points.iter().fold(DVec3::MIN, |a, b| a.max(*b)) / cell;
        let (low, high) = (low.floor().as_ivec3(), high.floor().as_ivec3());
        let mut keys = Vec::new();
        for x in low.x..=high.x {
            for y in low.y..=high.y {
                for z in low.z..=high.z {
                    keys.push([x, y, z]);
                }
            }
        }
        keys
    }

    /// Triangles near the points.
    pub fn near(&self, points: &[DVec3]) -> BTreeSet<usize> {
        Self::touched(points, self.cell)
            .iter()
            .filter_map(|key| self.cells.get(key))
            .flatten()
            .copied()
            .collect()
    }
}

/// Pairs of an edge and a triangle that cross without sharing a vertex; `cell` is about an edge's length.
pub fn self_intersections(surface: &Surface, cell: f64) -> usize {
    let grid = Grid::new(surface, cell);
    edges(&surface.triangles)
        .iter()
        .map(|&(i, j)| {
            let [a, b] = [i, j].map(|v| surface.positions[v as usize]);
            let apart = |t: &&usize| {
                let corners = surface.triangles[**t];
                !corners.contains(&i) && !corners.contains(&j)
            };
            grid.near(&[a, b])
                .iter()
                .filter(apart)
                .filter(|&&t| crossing(a, b - a, surface.corners(t)).is_some())
                .count()
        })
        .sum()
}

/// The smallest angle of a triangle, rad.
pub fn smallest_angle([a, b, c]: [DVec3; 3]) -> f64 {
    [(a, b, c), (b, c, a), (c, a, b)]
        .map(|(p, q, r)| (q - p).angle_between(r - p))
        .into_iter()
        .fold(f64::MAX, f64::min)
}

/// The skin weights of each vertex, one a bone: a partition of unity over `most` bones at most.
pub fn dense_weights<const BONES: usize>(
    model: &ParametricModel,
    most: usize,
) -> Vec<[f64; BONES]> {
    let dense = |row: &[SkinWeight]| {
        assert!((1..=most).contains(&row.len()));
        let mut dense = [0.0; BONES];
        row.iter().for_each(|w| dense[w.bone as usize] = w.weight);
        assert!(dense.iter().all(|&w| (0.0..=1.0).contains(&w)));
        assert!((dense.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        dense
    };
    model.weights.iter().map(dense).collect()
}

/// Panics unless `skin` is one closed manifold of genus 0 that does not cross itself; `cell` is about an edge's length, m.
pub fn assert_closed_sphere(skin: &Surface, cell: f64) {
    assert!(skin.is_closed() && is_manifold(skin));
    assert_eq!(components(skin), 1);
    let euler = skin.positions.len() as i64 - edges(&skin.triangles).len() as i64
        + skin.triangles.len() as i64;
    assert_eq!(euler, 2, "genus 0");
    assert_eq!(self_intersections(skin, cell), 0);
}
