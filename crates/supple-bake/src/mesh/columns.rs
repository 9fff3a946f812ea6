//! The columns of a prism shell: how deep each reaches.
//!
//! Where a tet of a prism would invert, or nearly, its columns become shorter; a column that gets too short vanishes, and
//! the layer ends there: the bone holds the skin.

use super::thickness::limit_slope;
use glam::DVec3;
use supple::model::{Surface, TetMesh};

/// A tet must keep this part of the volume that it would have if its three columns were parallel.
const LEAST_VOLUME: f64 = 0.02;

/// Factor on a column whose tets invert.
const SHRINKING: f64 = 0.8;

/// Rounds of shrinking, after which a column that still fails vanishes at once.
const SHRINKING_ROUNDS: usize = 60;

/// A column vanishes when it is shorter than this part of the mean edge around its vertex.
const LEAST_DEPTH: f64 = 0.1;

/// Greatest difference of two columns, relative to the length of the edge between them.
const SLOPE: f64 = 2.0;

/// Pieces of a column's path.
pub(super) const STEPS: usize = 16;

/// The columns of a shell and the tets between them.
pub(super) struct Columns {
    pub skin: Surface,
    /// Along each column, as deep as wanted.
    pub paths: Vec<[DVec3; STEPS + 1]>,
    /// That depth, m.
    pub wanted: Vec<f64>,
    pub layers: usize,
    /// Node l · vertices + v lies in column v at level l.
    pub tets: Vec<[u32; 4]>,
}

impl Columns {
    /// Shortens columns until every tet is sound; the mesh that is left, of as many nodes as at first. Those of vanished
    /// columns are merged into the skin's, and the tets along them are left out.
    pub fn sound_mesh(&self, depth: &mut [f64]) -> TetMesh {
        let areas: Vec<f64> = (0..self.skin.triangles.len())
            .map(|t| self.skin.area_vector(t).length())
            .collect();
        let least: Vec<f64> = (mean_edges(&self.skin).iter())
            .map(|edge| LEAST_DEPTH * edge)
            .collect();
        let mut mesh = TetMesh {
            nodes: Vec::new(),
            tets: self.tets.clone(),
        };
        for round in 0.. {
            limit_slope(&self.skin, depth, SLOPE);
            for (depth, least) in depth.iter_mut().zip(&least) {
                if depth.is_nan() || *depth < *least {
                    *depth = 0.0;
                }
            }
            mesh.nodes = self.nodes(depth);
            let failing = self.failing(&areas, depth, &mesh);
            if !failing.contains(&true) {
                break;
            }
            let factor = if round < SHRINKING_ROUNDS {
                SHRINKING
            } else {
                0.0
            };
            for (depth, _) in depth.iter_mut().zip(failing).filter(|(_, f)| *f) {
                *depth *= factor;
            }
        }
        let vertices = depth.len();
        mesh.tets.retain(|tet| {
            let own = twin(&tet.map(|n| n as usize % vertices));
            own.is_some_and(|v| depth[v] > 0.0)
        });
        for n in mesh.tets.iter_mut().flatten() {
            let v = *n as usize % vertices;
            if depth[v] == 0.0 {
                *n = v as u32;
            }
        }
        mesh
    }

    /// The columns of tets that are inverted or nearly so. A tet holds two nodes of one of its three
    /// columns; with parallel columns its volume is a third of the triangle's area times their distance.
    fn failing(&self, areas: &[f64], depth: &[f64], mesh: &TetMesh) -> Vec<bool> {
        let vertices = depth.len();
        let per_layer = 3 * self.skin.triangles.len();
        let mut failing = vec![false; vertices];
        for (t, tet) in mesh.tets.iter().enumerate() {
            let columns = tet.map(|n| n as usize % vertices);
            let Some(own) = twin(&columns).filter(|&v| depth[v] > 0.0) else {
                continue;
            };
            let straight = areas[t % per_layer / 3] * depth[own] / (3 * self.layers) as f64;
            let volume = mesh.volume(t);
            if volume.is_nan() || volume <= LEAST_VOLUME * straight {
                columns.iter().for_each(|&v| failing[v] = true);
            }
        }
        failing
    }

    /// The places of all nodes.
    fn nodes(&self, depth: &[f64]) -> Vec<DVec3> {
        let vertices = depth.len();
        let node = |n: usize| {
            let (level, v) = (n / vertices, n % vertices);
            let along = depth[v] / self.wanted[v].max(f64::MIN_POSITIVE) * level as f64
                / self.layers as f64
                * STEPS as f64;
            let piece = (along as usize).min(STEPS - 1);
            self.paths[v][piece].lerp(self.paths[v][piece + 1], along - piece as f64)
        };
        (0..(self.layers + 1) * vertices).map(node).collect()
    }
}

/// Mean length of the edges around each vertex, m.
fn mean_edges(skin: &Surface) -> Vec<f64> {
    let mut sums = vec![(0.0, 0); skin.positions.len()];
    for &[a, b, c] in &skin.triangles {
        for (u, v) in [(a, b), (b, c), (c, a)].map(|(u, v)| (u as usize, v as usize)) {
            let length = skin.positions[u].distance(skin.positions[v]);
            for w in [u, v] {
                sums[w].0 += length;
                sums[w].1 += 1;
            }
        }
    }
    let mean = |&(sum, count): &(f64, usize)| sum / count.max(1) as f64;
    sums.iter().map(mean).collect()
}

/// The value that occurs twice.
fn twin(values: &[usize; 4]) -> Option<usize> {
    (0..4).find_map(|i| values[i + 1..].contains(&values[i]).then_some(values[i]))
}
