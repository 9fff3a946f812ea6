//! Skin weights and pose blend shapes in the interior: harmonic extension from the skin.

use crate::basis::{HeldNodes, Role, largest_weights, scatter};
use crate::math::{SparseFactor, SparseSymmetric};
use supple::internal::math::Rows;
use supple::model::{PoseBlend, SkinWeight, TetMesh};
use supple::{Error, Result};

/// The Laplace problem of a layer, factored once: values at bones and at the skin are given.
#[derive(Debug)]
pub struct InteriorField<'a> {
    bone_of_node: &'a [Option<u32>],
    embedding: &'a Rows<(u32, f64)>,
    held: HeldNodes,
    /// Stiffness between a free and a held node: (column, node, value).
    coupling: Vec<(u32, u32, f64)>,
    factor: SparseFactor,
}

impl<'a> InteriorField<'a> {
    /// Factors the Laplacian of `mesh`; `skin_areas` is the area of each skin vertex, m².
    ///
    /// # Errors
    /// [`Error::Solve`] where a part of the mesh touches neither skin nor bone.
    pub fn new(
        mesh: &TetMesh,
        bone_of_node: &'a [Option<u32>],
        embedding: &'a Rows<(u32, f64)>,
        skin_areas: &[f64],
    ) -> Result<Self> {
        let held = HeldNodes::new(mesh, bone_of_node, embedding, skin_areas);
        let role = &held.role;
        let mut entries = Vec::new();
        let mut coupling = Vec::new();
        let mut add = |i: u32, j: u32, value: f64| match (role[i as usize], role[j as usize]) {
            (Role::Free(r), Role::Free(c)) if r >= c => entries.push((r, c, value)),
            (Role::Free(r), Role::Skin | Role::Bone(_)) => coupling.push((r, j, value)),
            _ => {}
        };
        for (t, tet) in mesh.tets.iter().enumerate() {
            let (volume, gradients) = (mesh.volume(t), mesh.barycentric_gradients(t));
            for (i, a) in tet.iter().zip(gradients) {
                for (j, b) in tet.iter().zip(gradients) {
                    add(*i, *j, volume * a.dot(b));
                }
            }
        }
        for &(vertex, stiffness) in &held.soft {
            for &(i, share_i) in embedding.row(vertex as usize) {
                for &(j, share_j) in embedding.row(vertex as usize) {
                    add(i, j, stiffness * share_i * share_j);
                }
            }
        }
        let matrix = SparseSymmetric::from_entries(held.free, &entries);
        Ok(Self {
            bone_of_node,
            embedding,
            held,
            coupling,
            factor: SparseFactor::new(&matrix, "interior skin weights")?,
        })
    }

    /// Extends fields 0..`count`, given at skin vertices and bones, and hands each one's values at
    /// the nodes to `take`.
    pub fn extend<T: Send>(
        &self,
        count: usize,
        on_skin: impl Fn(usize, u32) -> f64 + Sync + Send,
        on_bone: impl Fn(usize, u32) -> f64 + Sync + Send,
        take: impl Fn(usize, &[f64]) -> T + Sync + Send,
    ) -> Vec<T> {
        self.extend_from(count, on_skin, |field, _, bone| on_bone(field, bone), take)
    }

    /// [`InteriorField::extend`] of what differs between the nodes of a bone: `on_bone` gets field, node and bone.
    pub fn extend_from<T: Send>(
        &self,
        count: usize,
        on_skin: impl Fn(usize, u32) -> f64 + Sync + Send,
        on_bone: impl Fn(usize, u32, u32) -> f64 + Sync + Send,
        take: impl Fn(usize, &[f64]) -> T + Sync + Send,
    ) -> Vec<T> {
        let held = |field: usize| -> Vec<f64> {
            let mut values: Vec<f64> = (self.bone_of_node.iter().enumerate())
                .map(|(n, bone)| bone.map_or(0.0, |b| on_bone(field, n as u32, b)))
                .collect();
            for (node, value) in self.held.skin_values(|v| on_skin(field, v)) {
                values[node as usize] = value;
            }
            values
        };
        let load = |field: usize, b: &mut [f64]| {
            let held = held(field);
            for &(column, node, value) in &self.coupling {
                b[column as usize] -= value * held[node as usize];
            }
            for &(vertex, stiffness) in &self.held.soft {
                let pull = stiffness * on_skin(field, vertex);
                let row = self.embedding.row(vertex as usize).iter();
                let free: Vec<(u32, f64)> = row
                    .filter_map(|&(node, share)| match self.held.role[node as usize] {
                        Role::Free(column) => Some((column, share)),
                        _ => None,
                    })
                    .collect();
                scatter(&free, pull, b);
            }
        };
        self.factor.solve_each(count, load, |field, u| {
            let mut values = held(field);
            for (value, role) in values.iter_mut().zip(&self.held.role) {
                if let Role::Free(column) = role {
                    *value = u[*column as usize];
                }
            }
            take(field, &values)
        })
    }

    /// Bones of each node: one field a bone, its skin weight on the skin, 1 on its own surface and 0
    /// on the others'; clamped to 0 and above, the `most` largest kept and scaled to sum to 1.
    ///
    /// # Errors
    /// [`Error::Invalid`] where a node comes out without weight: the skin around it has none.
    pub fn skin_weights(
        &self,
        skinning: &Rows<SkinWeight>,
        bones: usize,
        most: usize,
    ) -> Result<Rows<SkinWeight>> {
        let on_skin = |bone: usize, vertex: u32| {
            let row = skinning.row(vertex as usize).iter();
            row.filter(|w| w.bone as usize == bone)
                .map(|w| w.weight)
                .sum()
        };
        let on_bone = |bone: usize, owner: u32| f64::from(u8::from(owner as usize == bone));
        // A field is as long as the mesh: none for a bone that is nowhere.
        let mut is_used = vec![false; bones];
        let weighted = skinning.entries().iter().filter(|w| w.weight != 0.0);
        let held = self.bone_of_node.iter().flatten();
        for bone in weighted.map(|w| w.bone).chain(held.copied()) {
            is_used[bone as usize] = true;
        }
        let used: Vec<usize> = (0..bones).filter(|&bone| is_used[bone]).collect();
        let fields = self.extend(
            used.len(),
            |field, vertex| on_skin(used[field], vertex),
            |field, owner| on_bone(used[field], owner),
            |_, u| u.to_vec(),
        );
        let rows: Result<Vec<Vec<SkinWeight>>> = (0..self.held.role.len())
            .map(|n| {
                let row = (used.iter().zip(&fields))
                    .filter(|(_, field)| field[n] > 0.0)
                    .map(|(&bone, field)| SkinWeight {
                        bone: bone as u32,
                        weight: field[n],
                    })
                    .collect();
                let row = largest_weights(row, most);
                let sum: f64 = row.iter().map(|w| w.weight).sum();
                if (sum - 1.0).abs() < 1e-9 {
                    Ok(row)
                } else {
                    let problem =
                        format!("none reaches node {n}: the skin around it has no weights");
                    Err(Error::invalid("skinning", problem))
                }
            })
            .collect();
        Ok(rows?.into_iter().collect())
    }

    /// Pose blend shapes at the centroids of `tets`: each column's three coordinates extended from
    /// the skin, 0 on bones, which are rigid.
    pub fn pose_blend(&self, skin: &PoseBlend, mesh: &TetMesh, tets: &[u32]) -> PoseBlend {
        let vertices = self.embedding.len();
        let value = |field: usize, vertex: u32| {
            f64::from(skin.columns[field / 3 * vertices + vertex as usize][field % 3])
        };
        let centroids = |_: usize, u: &[f64]| -> Vec<f32> {
            let mean = |t: &u32| {
                let nodes = mesh.tets[*t as usize].iter();
                (nodes.map(|&n| u[n as usize]).sum::<f64>() / 4.0) as f32
            };
            tets.iter().map(mean).collect()
        };
        let fields = self.extend(3 * skin.features, value, |_, _| 0.0, centroids);
        let columns = (fields.chunks_exact(3))
            .flat_map(|axes| (0..tets.len()).map(|i| [axes[0][i], axes[1][i], axes[2][i]]))
            .collect();
        PoseBlend {
            features: skin.features,
            columns,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_mesh::jittered_box;
    use glam::DVec3;

    const CELLS: [usize; 3] = [6, 5, 4];

    /// A box with bone 0 at its lowest layer, and as skin every node of its top layer.
    fn sample() -> (TetMesh, Vec<Option<u32>>, Vec<u32>) {
        let mesh = jittered_box(CELLS, 0.01, 0.1, 31);
        let layer = 7 * 6;
        let bones = (0..mesh.nodes.len())
            .map(|n| (n < layer).then_some(0))
            .collect();
        let top = (mesh.nodes.len() - layer..mesh.nodes.len())
            .map(|n| n as u32)
            .collect();
        (mesh, bones, top)
    }

    #[test]
    fn linear_fields_are_extended_exactly_from_skin_all_around() {
        let (mesh, _, _) = sample();
        // Skin on the whole boundary, no bone.
        let mut counts = vec![0; mesh.nodes.len()];
        mesh.boundary_triangles()
            .iter()
            .flatten()
            .for_each(|&n| counts[n as usize] += 1);
        let skin: Vec<u32> = (0..counts.len() as u32)
            .filter(|&n| counts[n as usize] > 0)
            .collect();
        let embedding: Rows<(u32, f64)> = skin.iter().map(|&n| [(n, 1.0)]).collect();
        let bones = vec![None; mesh.nodes.len()];
        let field = InteriorField::new(&mesh, &bones, &embedding, &vec![1.0; skin.len()]).unwrap();
        let value = |x: DVec3| 1.0 + 30.0 * x.x - 20.0 * x.y + 10.0 * x.z;
        let on_skin = |_: usize, v: u32| value(mesh.nodes[skin[v as usize] as usize]);
        let reached = field.extend(1, on_skin, |_, _| 0.0, |_, u| u.to_vec());
        for (u, x) in reached[0].iter().zip(&mesh.nodes) {
            assert!((u - value(*x)).abs() < 1e-12, "{u} at {x}");
        }
    }

    #[test]
    fn weights_fall_from_skin_to_the_bones_own() {
        let (mesh, bones, top) = sample();
        let embedding: Rows<(u32, f64)> = top.iter().map(|&n| [(n, 1.0)]).collect();
        let field = InteriorField::new(&mesh, &bones, &embedding, &vec![1.0; top.len()]).unwrap();
        let halves = |_: &u32| {
            [0.25, 0.75]
                .into_iter()
                .zip(0..)
                .map(|(weight, bone)| SkinWeight { bone, weight })
        };
        let skinning: Rows<SkinWeight> = top.iter().map(halves).collect();
        let weights = field.skin_weights(&skinning, 2, 4).unwrap();
        for (n, row) in weights.iter().enumerate() {
            let sum: f64 = row.iter().map(|w| w.weight).sum();
            assert!((sum - 1.0).abs() < 1e-14);
            let first = row.iter().find(|w| w.bone == 0).map_or(0.0, |w| w.weight);
            match bones[n] {
                Some(_) => assert_eq!(
                    row,
                    [SkinWeight {
                        bone: 0,
                        weight: 1.0
                    }]
                ),
                None if top.contains(&(n as u32)) => assert!((first - 0.25).abs() < 1e-14),
                // The maximum principle holds up to what obtuse tets spoil.
                None => assert!(first > 0.2 && first < 1.0, "{first}"),
            }
        }
    }

    #[test]
    fn embedded_skin_agrees_with_skin_at_nodes() {
        let (mesh, bones, top) = sample();
        let areas = vec![1e-4; top.len()];
        let nodes: Rows<(u32, f64)> = top.iter().map(|&n| [(n, 1.0)]).collect();
        // The same vertices written as points of a tet: a second node of no share.
        let embedded: Rows<(u32, f64)> = top.iter().map(|&n| [(n, 1.0), (n - 42, 0.0)]).collect();
        let skin = |_: usize, v: u32| mesh.nodes[top[v as usize] as usize].x * 20.0;
        let extend = |rows: &Rows<(u32, f64)>| {
            let field = InteriorField::new(&mesh, &bones, rows, &areas).unwrap();
            field
                .extend(1, skin, |_, _| 0.5, |_, u| u.to_vec())
                .remove(0)
        };
        let (exact, soft) = (extend(&nodes), extend(&embedded));
        let error = exact
            .iter()
            .zip(&soft)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        // ℓ is a hundredth of an edge: what the field changes by over ℓ, with the vertex areas lumped.
        assert!(error > 0.0 && error < 0.02, "{error}");
    }
}
