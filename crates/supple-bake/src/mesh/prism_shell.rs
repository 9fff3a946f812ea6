//! The soft layer of a skin without bone surfaces: prisms between the skin and a surface under it.
//!
//! Every vertex has a column: the way that it takes as the skin sinks ([`paths`]). How far each goes is in `columns`.

use super::columns::{Columns, STEPS};
use super::skin_filter::SkinFilter;
use super::sound_skin::SoundSkin;
use crate::body::LayerMesh;
use glam::DVec3;
use supple::Result;
use supple::model::Surface;

/// What is smaller than this part of the depth does not turn columns, and fades as the skin sinks.
const SMALL: f64 = 0.7;

/// The part of it that fades with each of a path's pieces.
const FADING: f64 = 0.05;

/// Meshes the layer under `sound`, `depth` deep (as asked for on entry, as made on return; 0 where the
/// layer ends), in `layers` layers. `bones` holds the inner surface, the rims of holes and the ends of the
/// layer, vertex by vertex. Nodes go layer by layer in the order of the vertices, the skin's first.
///
/// # Errors
/// [`supple::Error::Solve`] where numbers are out of range.
pub(super) fn prism_shell(
    sound: &SoundSkin,
    bones: &[u32],
    depth: &mut Vec<f64>,
    layers: usize,
) -> Result<LayerMesh> {
    let skin = sound.skin();
    let vertices = skin.positions.len();
    let columns = Columns {
        paths: paths(&skin, depth)?,
        wanted: depth.clone(),
        layers,
        tets: prism_tets(&skin.triangles, vertices, layers),
        skin,
    };
    let mesh = columns.sound_mesh(depth);

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
    Ok(layer)
}

/// The ways down from the vertices of a skin, `depth` long: each a polyline of [`STEPS`] equal pieces.
///
/// The skin sinks in small steps along its normals. What is small for the depth (a nipple, a wrinkle) neither turns
/// them, nor stays: it would close on itself long before.
fn paths(skin: &Surface, depth: &[f64]) -> Result<Vec<[DVec3; STEPS + 1]>> {
    let lengths: Vec<f64> = depth.iter().map(|d| SMALL * d).collect();
    let filter = SkinFilter::new(skin, &lengths)?;
    let mut sinking = skin.clone();
    let mut paths: Vec<[DVec3; STEPS + 1]> =
        skin.positions.iter().map(|&p| [p; STEPS + 1]).collect();
    for step in 1..=STEPS {
        let normals = filter.smooth(&sinking.vertex_normals());
        for ((place, normal), depth) in sinking.positions.iter_mut().zip(normals).zip(depth) {
            *place -= depth / STEPS as f64 * normal.normalize_or_zero();
        }
        let smooth = filter.without_small(&sinking.positions);
        for (place, smooth) in sinking.positions.iter_mut().zip(smooth) {
            *place += FADING * (smooth - *place);
        }
        for (path, &place) in paths.iter_mut().zip(&sinking.positions) {
            path[step] = place;
        }
    }
    Ok(paths)
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
        let layer = prism_shell(&sound, &bones, &mut depth, layers).unwrap();
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
        assert!(least < 0.012, "{made:?}");
        let bare = made.iter().filter(|d| **d == 0.0).count();
        assert!(20 * bare < made.len(), "{bare}");
    }

    /// A breast as bodies are modelled: a dome, and on top of it triangles a tenth as long as around it. Their columns
    /// run to one place long before they are as deep as the dome's.
    #[test]
    fn fine_triangles_on_a_dome_stay_over_deep_tissue() {
        let mut skin = sphere(0.1, 5);
        for p in &mut skin.positions {
            let polar = p.angle_between(DVec3::Z);
            // What is within 0.5 of the pole moves towards it; a dome of 25 mm in radius rises there.
            if polar < 0.5 {
                let finer = polar * (0.1 + 0.9 * polar / 0.5);
                let (sine, cosine) = finer.sin_cos();
                let around = p.truncate().normalize_or_zero();
                let rise = 0.03 * (1.0 - (finer / 0.28).powi(2)).max(0.0).sqrt();
                *p = (0.1 + rise) * (sine * around.extend(0.0) + DVec3::Z * cosine);
            }
        }
        let wanted = 0.045;
        let (layer, made) = shell(&skin, wanted, 1);
        let tip = (0..made.len()).max_by(|&a, &b| {
            let height = |v: usize| skin.positions[v].z;
            height(a).total_cmp(&height(b))
        });
        let least = made.iter().copied().fold(1.0, f64::min);
        println!(
            "{} nodes, tip {:?}, least {least}",
            layer.mesh.nodes.len(),
            tip.map(|v| made[v])
        );
        assert!(made[tip.unwrap()] > 0.75 * wanted && least > 0.5 * wanted);
        // The skin itself is free everywhere.
        for row in layer.skin_embedding.iter() {
            assert!(
                row.iter()
                    .all(|&(n, _)| layer.bone_of_node[n as usize].is_none())
            );
        }
    }

    #[test]
    fn the_layer_ends_where_no_column_fits() {
        let mut skin = sphere(0.02, 3);
        // A vertex drawn far over its neighbours: triangles look inward that no column can be inside of.
        let at = skin.positions[70];
        let aside = at.any_orthonormal_vector();
        skin.positions[70] = 0.02 * (at.normalize() + 0.8 * aside).normalize();
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
