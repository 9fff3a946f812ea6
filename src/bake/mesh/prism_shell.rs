//! The soft layer of a skin without bone surfaces: prisms between the skin and a surface under it.
//!
//! Depth of vertex v: min(thickness, ½ local radius), the local radius being that of the largest ball
//! inside the skin that touches it at v; then smoothed so that it changes by at most half the
//! distance along the skin, and shrunk where a tet would invert.

use crate::math::par_map;
use crate::model::{LayerMesh, SkinWeight, Surface, TetMesh};
use crate::{Error, Result, math::Rows};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// How a shell is made.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShellOptions {
    /// Greatest depth of the layer, m.
    pub thickness: f64,
    /// Number of prism layers.
    pub layers: usize,
}

/// Greatest change of depth along an edge, relative to its length.
const DEPTH_SLOPE: f64 = 0.5;

/// A tet must keep this part of the volume that its prism would have if its normals were parallel.
const LEAST_VOLUME: f64 = 0.2;

/// Steps of shrinking by 0.8 before giving up: to 1e-6 of the depth.
const SHRINKING_STEPS: usize = 60;

/// Meshes the layer under `skin` (closed and welded); nodes of the inner surface are held by their
/// vertex's bone of largest weight. Node `l * vertices + v` lies under vertex `v`, `l` = 0 on the skin.
///
/// # Errors
/// [`Error::Invalid`] where the skin is open, folded or has a vertex without weight, or an option is
/// out of range.
pub fn prism_shell(
    skin: &Surface,
    skinning: &Rows<SkinWeight>,
    options: ShellOptions,
) -> Result<LayerMesh> {
    let ShellOptions { thickness, layers } = options;
    let vertices = skin.positions.len();
    if !(thickness > 0.0 && thickness.is_finite()) {
        return Err(Error::invalid("thickness", "must be positive (m)"));
    }
    if !(1..=16).contains(&layers) {
        return Err(Error::invalid("layers", "must be 1 to 16"));
    }
    skinning.validate("skinning", vertices)?;
    if (skin.triangles.iter().flatten()).any(|&v| v as usize >= vertices) {
        return Err(Error::invalid("skin", "names a vertex that is not there"));
    }
    if !skin.is_closed() {
        let cure = "is open or not welded: weld its seams and close its holes";
        return Err(Error::invalid("skin", cure));
    }
    let bones = skinning
        .iter()
        .enumerate()
        .map(|(v, row)| {
            (row.iter()
                .max_by(|a, b| a.weight.total_cmp(&b.weight).then(b.bone.cmp(&a.bone))))
            .map(|w| w.bone)
            .ok_or_else(|| Error::invalid("skinning", format!("vertex {v} has no bone")))
        })
        .collect::<Result<Vec<u32>>>()?;

    let normals = skin.vertex_normals();
    let mut depth: Vec<f64> = local_radius(skin, &normals)
        .into_iter()
        .map(|radius| thickness.min(0.5 * radius))
        .collect();
    limit_slope(skin, &mut depth);
    let tets = prism_tets(&skin.triangles, vertices, layers);
    let mesh = shrink_until_valid(skin, &normals, depth, tets, layers)?;
    let inner = layers * vertices;
    Ok(LayerMesh {
        tissue_fraction: vec![1.0; mesh.tets.len()],
        bone_of_node: (0..mesh.nodes.len())
            .map(|n| n.checked_sub(inner).map(|v| bones[v]))
            .collect(),
        skin_embedding: (0..vertices as u32).map(|v| [(v, 1.0)]).collect(),
        mesh,
    })
}

/// Radius of the largest ball that touches the skin at each vertex from inside, m: the least
/// |p − q|² / (2 n·(p − q)) over the vertices q that face another way (by 60° or more: nearby ones
/// would turn the error of a normal into a tiny ball).
pub fn local_radius(skin: &Surface, normals: &[DVec3]) -> Vec<f64> {
    par_map(skin.positions.len(), |v| {
        let (p, n) = (skin.positions[v], normals[v]);
        (skin.positions.iter().zip(normals))
            .filter(|&(_, other)| n.dot(*other) < 0.5)
            .map(|(q, _)| (p - *q, n.dot(p - *q)))
            .filter(|&(_, height)| height > 0.0)
            .map(|(offset, height)| offset.length_squared() / (2.0 * height))
            .fold(f64::INFINITY, f64::min)
    })
}

/// Lowers `depth` until it changes by [`DEPTH_SLOPE`] at most along every edge.
fn limit_slope(skin: &Surface, depth: &mut [f64]) {
    let mut changed = true;
    // Each sweep settles at least one vertex more.
    while changed {
        changed = false;
        for &[a, b, c] in &skin.triangles {
            for (u, v) in [(a, b), (b, c), (c, a)] {
                let (u, v) = (u as usize, v as usize);
                let reach = DEPTH_SLOPE * (skin.positions[u] - skin.positions[v]).length();
                if depth[u] > depth[v] + reach {
                    depth[u] = depth[v] + reach;
                    changed = true;
                }
            }
        }
    }
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

/// Places the nodes, and shrinks the depth of every vertex whose tets invert or nearly do.
fn shrink_until_valid(
    skin: &Surface,
    normals: &[DVec3],
    mut depth: Vec<f64>,
    tets: Vec<[u32; 4]>,
    layers: usize,
) -> Result<TetMesh> {
    let vertices = skin.positions.len();
    let per_layer = 3 * skin.triangles.len();
    let areas: Vec<f64> = (0..skin.triangles.len())
        .map(|t| skin.area_vector(t).length())
        .collect();
    let mut mesh = TetMesh {
        nodes: Vec::new(),
        tets,
    };
    for _ in 0..SHRINKING_STEPS {
        mesh.nodes = (0..(layers + 1) * vertices)
            .map(|n| {
                let (layer, v) = (n / vertices, n % vertices);
                skin.positions[v] - normals[v] * (depth[v] * layer as f64 / layers as f64)
            })
            .collect();
        let mut shrink = vec![false; vertices];
        for (t, tet) in mesh.tets.iter().enumerate() {
            let triangle = t % per_layer / 3;
            let height = (skin.triangles[triangle].iter())
                .map(|&v| depth[v as usize])
                .fold(f64::INFINITY, f64::min)
                / layers as f64;
            let straight = areas[triangle] * height / 3.0;
            let volume = mesh.volume(t);
            if volume.is_nan() || volume <= LEAST_VOLUME * straight {
                tet.iter()
                    .for_each(|&n| shrink[n as usize % vertices] = true);
            }
        }
        if !shrink.contains(&true) {
            return Ok(mesh);
        }
        for (depth, _) in depth.iter_mut().zip(shrink).filter(|(_, s)| *s) {
            *depth *= 0.8;
        }
    }
    let volume = |&t: &usize| mesh.volume(t);
    let bad = (0..mesh.tets.len()).min_by(|a, b| volume(a).total_cmp(&volume(b)));
    let place = bad.map_or(DVec3::NAN, |t| mesh.centroid(t));
    Err(Error::invalid(
        "skin",
        format!("is folded or degenerate near {place:.4} m: smooth it there or merge its vertices"),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::mesh::MeshQuality;
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

    fn one_bone(vertices: usize) -> Rows<SkinWeight> {
        (0..vertices)
            .map(|_| {
                [SkinWeight {
                    bone: 0,
                    weight: 1.0,
                }]
            })
            .collect()
    }

    #[test]
    fn a_ball_gets_half_its_radius_at_most() {
        let skin = sphere(0.02, 3);
        let weights = one_bone(skin.positions.len());
        for (thickness, depth) in [(0.004, 0.004), (1.0, 0.01)] {
            let options = ShellOptions {
                thickness,
                layers: 2,
            };
            let layer = prism_shell(&skin, &weights, options).unwrap();
            layer.validate(skin.positions.len(), 1).unwrap();
            let quality = MeshQuality::of(&layer.mesh);
            assert_eq!(quality.inverted, 0);
            // A shell between two similar polyhedra.
            let expected = skin.volume() * (1.0 - (1.0 - depth / 0.02f64).powi(3));
            // The measured radius is short by what the vertex normals are off: some degrees here.
            let least = if thickness < 0.01 { 0.99 } else { 0.9 };
            let ratio = quality.volume / expected;
            assert!((least..1.01).contains(&ratio), "{ratio}");
            let boundary = Surface {
                positions: layer.mesh.nodes.clone(),
                triangles: layer.mesh.boundary_triangles(),
            };
            assert!(boundary.is_closed());
            assert_relative_eq!(boundary.volume(), quality.volume, max_relative = 1e-12);
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
        let options = ShellOptions {
            thickness: 0.02,
            layers: 3,
        };
        let layer = prism_shell(&skin, &one_bone(skin.positions.len()), options).unwrap();
        assert_eq!(MeshQuality::of(&layer.mesh).inverted, 0);
    }

    #[test]
    fn open_skins_and_bad_options_are_errors() {
        let mut skin = sphere(0.02, 1);
        let weights = one_bone(skin.positions.len());
        let options = ShellOptions {
            thickness: 0.004,
            layers: 1,
        };
        let bad =
            |thickness, layers| prism_shell(&skin, &weights, ShellOptions { thickness, layers });
        assert!(bad(0.0, 1).is_err() && bad(f64::NAN, 1).is_err() && bad(0.01, 0).is_err());
        assert!(prism_shell(&skin, &one_bone(3), options).is_err());
        skin.triangles.pop();
        let message = prism_shell(&skin, &weights, options)
            .unwrap_err()
            .to_string();
        assert!(message.contains("open"), "{message}");
    }
}
