//! The soft layer of a skin without bone surfaces: prisms between the skin and a surface under it.
//!
//! Every vertex has a column: the way that it takes as the skin sinks. Where a tet of a prism would invert, or nearly, its columns become shorter; a column
//! that gets too short vanishes, and the layer ends there: the bone holds the skin.

use super::sound_skin::SoundSkin;
use super::thickness::{limit_slope, neighbours};
use crate::body::LayerMesh;
use glam::DVec3;
use supple::internal::math::par_map;
use supple::model::{Surface, TetMesh};

/// A tet must keep this part of the volume that it would have if its three columns were parallel.
const LEAST_VOLUME: f64 = 0.1;

/// Factor on a column whose tets invert.
const SHRINKING: f64 = 0.8;

/// Rounds of shrinking, after which a column that still fails vanishes at once.
const SHRINKING_ROUNDS: usize = 60;

/// A column vanishes when it is shorter than this part of the mean edge around its vertex.
const LEAST_DEPTH: f64 = 0.1;

/// Greatest difference of two columns, relative to the length of the edge between them.
const SLOPE: f64 = 1.0;

/// Pieces of a column's path.
const STEPS: usize = 16;

/// Rounds of averaging of the normals at each of these.
const NORMAL_SMOOTHING: usize = 3;

/// The part of the way to the middle of its neighbours that a vertex then goes, less what they go themselves.
const PLACE_SMOOTHING: f64 = 0.25;

/// Smoothing is in full where a step is longer than this part of the mean edge around a vertex.
const SMOOTHED: f64 = 0.2;

/// Meshes the layer under `sound`, `depth` deep (as asked for on entry, as made on return; 0 where the
/// layer ends), in `layers` layers. `bones` holds the inner surface, the rims of holes and the ends of the
/// layer, vertex by vertex. Nodes go layer by layer in the order of the vertices, the skin's first.
pub(super) fn prism_shell(
    sound: &SoundSkin,
    bones: &[u32],
    depth: &mut Vec<f64>,
    layers: usize,
) -> LayerMesh {
    let skin = sound.skin();
    let vertices = skin.positions.len();
    let columns = Columns {
        paths: paths(&skin, depth),
        wanted: depth.clone(),
        layers,
        areas: (0..skin.triangles.len())
            .map(|t| skin.area_vector(t).length())
            .collect(),
        tets: prism_tets(&skin.triangles, vertices, layers),
        skin,
    };
    columns.shorten(depth);
    let mesh = columns.mesh(depth);

    // Only what tets use; those of vanished columns are the skin's.
    let mut used = vec![false; mesh.nodes.len()];
    (mesh.tets.iter().flatten()).for_each(|&n| used[n as usize] = true);
    let mut number = vec![u32::MAX; mesh.nodes.len()];
    let mut layer = LayerMesh::default();
    for n in (0..mesh.nodes.len()).filter(|&n| used[n]) {
        let (level, v) = (n / vertices, n % vertices);
        number[n] = layer.mesh.nodes.len() as u32;
        layer.mesh.nodes.push(mesh.nodes[n]);
        let held = level == layers || depth[v] == 0.0 || sound.held[v];
        layer.bone_of_node.push(held.then_some(bones[v]));
    }
    layer.mesh.tets = (mesh.tets.iter())
        .map(|tet| tet.map(|n| number[n as usize]))
        .collect();
    layer.tissue_fraction = vec![1.0; layer.mesh.tets.len()];
    let twin = |v: usize| sound.stands_for[v] as usize;
    layer.skin_embedding = (0..vertices)
        .map(|v| used[twin(v)].then_some((number[twin(v)], 1.0)))
        .collect();
    *depth = (0..vertices)
        .map(|v| if used[twin(v)] { depth[twin(v)] } else { 0.0 })
        .collect();
    layer
}

/// The columns of a shell and the tets between them.
struct Columns {
    skin: Surface,
    /// Along each column, as deep as wanted.
    paths: Vec<[DVec3; STEPS + 1]>,
    /// That depth, m.
    wanted: Vec<f64>,
    layers: usize,
    /// Of the skin's triangles, m².
    areas: Vec<f64>,
    /// Node l · vertices + v lies in column v at level l.
    tets: Vec<[u32; 4]>,
}

impl Columns {
    /// Shortens columns until every tet is sound.
    fn shorten(&self, depth: &mut [f64]) {
        let least: Vec<f64> = (mean_edges(&self.skin).iter())
            .map(|edge| LEAST_DEPTH * edge)
            .collect();
        for round in 0.. {
            limit_slope(&self.skin, depth, SLOPE);
            for (depth, least) in depth.iter_mut().zip(&least) {
                if depth.is_nan() || *depth < *least {
                    *depth = 0.0;
                }
            }
            let failing = self.failing(depth);
            if !failing.contains(&true) {
                return;
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
    }

    /// The columns of tets that are inverted or nearly so. A tet holds two nodes of one of its three
    /// columns; with parallel columns its volume is a third of the triangle's area times their distance.
    fn failing(&self, depth: &[f64]) -> Vec<bool> {
        let vertices = depth.len();
        let mesh = self.mesh_of_all(depth);
        let per_layer = 3 * self.skin.triangles.len();
        let mut failing = vec![false; vertices];
        for (t, tet) in mesh.tets.iter().enumerate() {
            let columns = tet.map(|n| n as usize % vertices);
            let Some(own) = twin(&columns).filter(|&v| depth[v] > 0.0) else {
                continue;
            };
            let straight = self.areas[t % per_layer / 3] * depth[own] / (3 * self.layers) as f64;
            let volume = mesh.volume(t);
            if volume.is_nan() || volume <= LEAST_VOLUME * straight {
                columns.iter().for_each(|&v| failing[v] = true);
            }
        }
        failing
    }

    fn mesh_of_all(&self, depth: &[f64]) -> TetMesh {
        let vertices = depth.len();
        let node = |n: usize| {
            let (level, v) = (n / vertices, n % vertices);
            let along = depth[v] / self.wanted[v].max(f64::MIN_POSITIVE) * level as f64
                / self.layers as f64
                * STEPS as f64;
            let piece = (along as usize).min(STEPS - 1);
            self.paths[v][piece].lerp(self.paths[v][piece + 1], along - piece as f64)
        };
        TetMesh {
            nodes: (0..(self.layers + 1) * vertices).map(node).collect(),
            tets: self.tets.clone(),
        }
    }

    /// The mesh with the nodes of vanished columns merged into the skin's and the tets along them left
    /// out.
    fn mesh(&self, depth: &[f64]) -> TetMesh {
        let vertices = depth.len();
        let mut mesh = self.mesh_of_all(depth);
        let merged = |n: u32| {
            let v = n as usize % vertices;
            if depth[v] > 0.0 { n } else { v as u32 }
        };
        mesh.tets = (mesh.tets.iter())
            .filter(|tet| {
                let own = twin(&tet.map(|n| n as usize % vertices));
                own.is_some_and(|v| depth[v] > 0.0)
            })
            .map(|tet| tet.map(merged))
            .collect();
        mesh
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

/// The ways down from the vertices of a skin, `depth` long: each a polyline of [`STEPS`] equal pieces.
///
/// The skin sinks in small steps along its normals, and is smoothed as it sinks, so that what is small (a
/// nipple, a wrinkle) does not narrow what lies below it.
fn paths(skin: &Surface, depth: &[f64]) -> Vec<[DVec3; STEPS + 1]> {
    let neighbours = neighbours(skin);
    let mean = |values: &[DVec3], v: usize| {
        let row = neighbours.row(v);
        row.iter().map(|&u| values[u as usize]).sum::<DVec3>() / row.len().max(1) as f64
    };
    let mut sinking = skin.clone();
    let mut paths: Vec<[DVec3; STEPS + 1]> =
        skin.positions.iter().map(|&p| [p; STEPS + 1]).collect();
    // A layer that is thin compared with its triangles follows the skin as it is.
    let smoothing: Vec<f64> = (mean_edges(skin).iter().zip(depth))
        .map(|(edge, depth)| (depth / (STEPS as f64 * SMOOTHED * edge)).clamp(0.0, 1.0))
        .collect();
    for step in 1..=STEPS {
        let mut normals = sinking.vertex_normals();
        for _ in 0..NORMAL_SMOOTHING {
            normals = par_map(normals.len(), |v| {
                (normals[v] + smoothing[v] * mean(&normals, v)).normalize_or_zero()
            });
        }
        let before = &sinking.positions;
        let sunk = par_map(before.len(), |v| {
            before[v] - depth[v] / STEPS as f64 * normals[v]
        });
        let off = par_map(sunk.len(), |v| mean(&sunk, v) - sunk[v]);
        sinking.positions = par_map(sunk.len(), |v| match neighbours.row(v) {
            [] => sunk[v],
            // What all of them are off by is the surface's own curvature.
            _ => sunk[v] + PLACE_SMOOTHING * smoothing[v] * (off[v] - mean(&off, v)),
        });
        for (path, &place) in paths.iter_mut().zip(&sinking.positions) {
            path[step] = place;
        }
    }
    paths
}

/// Three tets for every prism. Each side is cut by the diagonal from its smallest vertex, so that
/// neighbours agree (Dompierre et al. 1999).
fn prism_tets(triangles: &[[u32; 3]], vertices: usize, layers: usize) -> Vec<[u32; 4]> {
    let mut tets = Vec::with_capacity(3 * layers * triangles.len());
    for layer in 0..layers {
        let (outer, inner) = ((layer * vertices) as u32, ((layer + 1) * vertices) as u32);
        for &[a, b, c] in triangles {
            // The smallest vertex first by rotation, which keeps the orientation.
            let [a, b, c] = if a < b && a < c {
                [a, b, c]
            } else if b < c {
                [b, c, a]
            } else {
                [c, a, b]
            };
            let [a0, b0, c0] = [a, b, c].map(|v| v + outer);
            let [a1, b1, c1] = [a, b, c].map(|v| v + inner);
            tets.push([a0, b1, a1, c1]);
            if b < c {
                tets.extend([[a0, c0, b0, c1], [a0, b0, b1, c1]]);
            } else {
                tets.extend([[a0, c0, b0, b1], [a0, c1, c0, b1]]);
            }
        }
    }
    tets
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::quality::MeshQuality;
    use approx::assert_relative_eq;

    /// A sphere from an octahedron split `times` times.
    fn sphere(radius: f64, times: usize) -> Surface {
        let mut positions = vec![
            DVec3::X,
            DVec3::Y,
            DVec3::Z,
            -DVec3::X,
            -DVec3::Y,
            -DVec3::Z,
        ];
        let mut triangles = vec![
            [0, 1, 2],
            [1, 3, 2],
            [3, 4, 2],
            [4, 0, 2],
            [1, 0, 5],
            [3, 1, 5],
            [4, 3, 5],
            [0, 4, 5],
        ];
        for _ in 0..times {
            let mut middles = std::collections::HashMap::new();
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    positions.push((positions[a as usize] + positions[b as usize]).normalize());
                    positions.len() as u32 - 1
                })
            };
            triangles = triangles
                .iter()
                .flat_map(|&[a, b, c]: &[u32; 3]| {
                    let (d, e, f) = (middle(a, b), middle(b, c), middle(c, a));
                    [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
                })
                .collect();
        }
        positions.iter_mut().for_each(|p| *p *= radius);
        Surface {
            positions,
            triangles,
        }
    }

    /// A shell under one bone's skin, its options by thickness and layers.
    fn shell(skin: &Surface, thickness: f64, layers: usize) -> (LayerMesh, Vec<f64>) {
        let sound = SoundSkin::new(skin).unwrap();
        let mut depth = vec![thickness; skin.positions.len()];
        let bones = vec![0; skin.positions.len()];
        let layer = prism_shell(&sound, &bones, &mut depth, layers);
        layer.validate(skin.positions.len(), 1).unwrap();
        assert_eq!(MeshQuality::of(&layer.mesh).inverted, 0);
        (layer, depth)
    }

    #[test]
    fn a_ball_gets_the_volume_between_two_spheres() {
        let skin = sphere(0.02, 3);
        for depth in [0.004, 0.01] {
            let (layer, made) = shell(&skin, depth, 2);
            assert!(
                made.iter().all(|d| (0.99..1.001).contains(&(d / depth))),
                "{made:?}"
            );
            let volume = layer.tissue_volume();
            // Two similar polyhedra.
            let expected = skin.volume() * (1.0 - (1.0 - depth / 0.02f64).powi(3));
            assert_relative_eq!(volume, expected, max_relative = 0.02);
            let boundary = Surface {
                positions: layer.mesh.nodes.clone(),
                triangles: layer.mesh.boundary_triangles(),
            };
            assert!(boundary.is_closed());
            assert_relative_eq!(boundary.volume(), volume, max_relative = 1e-12);
            assert_eq!(boundary.triangles.len(), 2 * skin.triangles.len());
            let held = layer.bone_of_node.iter().flatten().count();
            assert_eq!(held, skin.positions.len());
        }
    }

    #[test]
    fn a_dented_ball_shrinks_instead_of_inverting() {
        let mut skin = sphere(0.02, 3);
        // A narrow, steep dent.
        for p in &mut skin.positions {
            let off = p.truncate().length() / 0.004;
            if p.z > 0.0 {
                p.z -= 0.012 * (-off * off).exp();
            }
        }
        let (_, made) = shell(&skin, 0.02, 3);
        let least = made.iter().copied().fold(1.0, f64::min);
        assert!(least < 0.01, "{made:?}");
        let bare = made.iter().filter(|d| **d == 0.0).count();
        assert!(20 * bare < made.len(), "{bare}");
    }

    #[test]
    fn the_layer_ends_where_no_column_fits() {
        let mut skin = sphere(0.02, 3);
        // A vertex pushed through the opposite side: its triangles are needles that cut everything.
        skin.positions[7] *= -1.5;
        let (layer, made) = shell(&skin, 0.005, 2);
        let gone: Vec<usize> = (0..made.len()).filter(|&v| made[v] == 0.0).collect();
        assert!(!gone.is_empty() && gone.len() < 20, "{gone:?}");
        for v in gone {
            for &(n, _) in layer.skin_embedding.row(v) {
                assert_eq!(layer.bone_of_node[n as usize], Some(0));
            }
        }
    }
}
