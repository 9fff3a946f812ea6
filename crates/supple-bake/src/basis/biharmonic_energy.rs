//! The smoothness energies of a tet mesh in their facet form.

use glam::DVec3;
use serde::{Deserialize, Serialize};
use supple::model::TetMesh;

/// What the basis minimises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BasisEnergy {
    /// ∫ (Δu)²: k = 2.
    #[default]
    Biharmonic,
    /// ∫ |∇Δu|²: k = 3. Smoother at the handles, wider, and several times the bake's time.
    Triharmonic,
}

impl BasisEnergy {
    /// A as entries (row ≥ column); entries of one place add up. Its null space is the affine functions, on every part
    /// of the mesh whose tets hang together by faces. Unit: 1/m for k = 2, 1/m³ for k = 3.
    pub fn entries(self, mesh: &TetMesh) -> Vec<(u32, u32, f64)> {
        match self {
            Self::Biharmonic => biharmonic_energy(mesh),
            Self::Triharmonic => triharmonic_energy(mesh),
        }
    }
}

/// The squared jump of ∂u/∂n over interior faces, as entries (row ≥ column) of
///
/// A = Σ_f (1/m_f) r_f r_fᵀ,  m_f = (vol₁ + vol₂)/4,
/// r_f\[j\] = Σ over the two tets t of f of 3 vol_t ∇λ_{t,opp(f)} · ∇λ_{t,j}.
///
/// This is libigl's `biharmonic_coordinates` with k = 2; the vertex form printed in the paper
/// carries an erratum.
pub fn biharmonic_energy(mesh: &TetMesh) -> Vec<(u32, u32, f64)> {
    let mut entries = Vec::with_capacity(mesh.tets.len() * 32);
    for face in interior_faces(mesh) {
        let Jump { nodes, jump, mass } = Jump::of(mesh, face);
        for (i, &row) in nodes.iter().enumerate() {
            for (j, &column) in nodes.iter().enumerate() {
                if row >= column {
                    entries.push((row, column, jump[i] * jump[j] / mass));
                }
            }
        }
    }
    entries
}

/// The squared gradient of the Laplacian, as entries (row ≥ column) of
///
/// A = Σ_t vol_t G_tᵀ G_t,  G_t u = Σ over the faces f of t of ∇ψ_f (r_f · u)/m_f,  ∇ψ_f = −3 ∇λ_{t,opp(f)}:
///
/// the Laplacian r_f · u / m_f lives on the faces as a Crouzeix–Raviart function (1 in the middle of its
/// own face and 0 in those of the others) and is 0 on the boundary.
fn triharmonic_energy(mesh: &TetMesh) -> Vec<(u32, u32, f64)> {
    let mut gradients: Vec<Vec<(u32, DVec3)>> = vec![Vec::new(); mesh.tets.len()];
    for face in interior_faces(mesh) {
        let Jump { nodes, jump, mass } = Jump::of(mesh, face);
        for (tet, opposite) in face {
            let slope = -3.0 * mesh.barycentric_gradients(tet)[opposite];
            let row = &mut gradients[tet];
            for (&node, jump) in nodes.iter().zip(jump) {
                let term = jump / mass * slope;
                match row.iter_mut().find(|e| e.0 == node) {
                    Some(entry) => entry.1 += term,
                    None => row.push((node, term)),
                }
            }
        }
    }
    let mut entries = Vec::with_capacity(mesh.tets.len() * 36);
    for (tet, row) in gradients.iter().enumerate() {
        let volume = mesh.volume(tet);
        for &(i, left) in row {
            let below = row.iter().filter(|e| e.0 <= i);
            entries.extend(below.map(|&(j, right)| (i, j, volume * left.dot(right))));
        }
    }
    entries
}

/// What a face measures of u: r_f · u is the jump of ∂u/∂n over it, times its area.
struct Jump {
    /// The first tet's corners and the second's own one.
    nodes: [u32; 5],
    /// r_f at these.
    jump: [f64; 5],
    /// m_f, m³.
    mass: f64,
}

impl Jump {
    /// Of a face given by (tet, opposite corner) on both sides.
    fn of(mesh: &TetMesh, face: [(usize, usize); 2]) -> Self {
        let mut nodes = [0u32; 5];
        let mut jump = [0.0; 5];
        let mut volume = 0.0;
        for (side, (tet, opposite)) in face.into_iter().enumerate() {
            let gradients = mesh.barycentric_gradients(tet);
            let tet_volume = mesh.volume(tet);
            volume += tet_volume;
            for (corner, &node) in mesh.tets[tet].iter().enumerate() {
                let slot = match side {
                    0 => corner,
                    _ => nodes[..4].iter().position(|&n| n == node).unwrap_or(4),
                };
                nodes[slot] = node;
                jump[slot] += 3.0 * tet_volume * gradients[opposite].dot(gradients[corner]);
            }
        }
        let mass = volume / 4.0;
        Self { nodes, jump, mass }
    }
}

/// The faces between two tets: (tet, opposite corner) of each side, by rising nodes. Where a lattice
/// branches, several tets lie on one side of a face: each is paired with each of the other side.
pub(crate) fn interior_faces(mesh: &TetMesh) -> Vec<[(usize, usize); 2]> {
    let mut sides: Vec<([u32; 3], bool, u32)> = (0..mesh.tets.len())
        .flat_map(|t| {
            let faces = mesh.faces(t).into_iter().enumerate();
            faces.map(move |(corner, face)| {
                let (sorted, even) = sorted_with_parity(face);
                (sorted, even, (4 * t + corner) as u32)
            })
        })
        .collect();
    sides.sort_unstable();
    let mut faces = Vec::with_capacity(mesh.tets.len() * 2);
    for around in sides.chunk_by(|a, b| a.0 == b.0) {
        let (below, above) = around.split_at(around.partition_point(|side| !side.1));
        for &(_, _, a) in below {
            for &(_, _, b) in above {
                faces.push([a, b].map(|side| (side as usize / 4, side as usize % 4)));
            }
        }
    }
    faces
}

/// The nodes rising, and whether the order given turns the same way round.
fn sorted_with_parity([a, b, c]: [u32; 3]) -> ([u32; 3], bool) {
    let mut sorted = [a, b, c];
    sorted.sort_unstable();
    let cyclic = [[a, b, c], [b, c, a], [c, a, b]];
    (sorted, cyclic.contains(&sorted))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::SparseSymmetric;
    use crate::test_mesh::jittered_box;
    use glam::DVec3;

    fn energy(mesh: &TetMesh) -> SparseSymmetric {
        SparseSymmetric::from_entries(mesh.nodes.len(), &biharmonic_energy(mesh))
    }

    const ENERGIES: [BasisEnergy; 2] = [BasisEnergy::Biharmonic, BasisEnergy::Triharmonic];

    #[test]
    fn a_branching_face_keeps_the_affine_functions() {
        // One tet below the face, two on the same nodes' other side with apexes of their own.
        let nodes = [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -2.0],
        ];
        let mesh = TetMesh {
            nodes: nodes.map(DVec3::from).to_vec(),
            tets: vec![[0, 1, 2, 3], [0, 1, 2, 4], [0, 2, 1, 5]],
        };
        assert_eq!(interior_faces(&mesh).len(), 2);
        let direction = DVec3::new(1.0, -2.0, 3.0);
        let u: Vec<f64> = mesh.nodes.iter().map(|x| direction.dot(*x)).collect();
        assert!(energy(&mesh).multiply(&u).iter().all(|r| r.abs() < 1e-14));
    }

    #[test]
    fn null_space_is_exactly_the_affine_functions() {
        let mesh = jittered_box([2, 2, 2], 0.01, 0.2, 7);
        for energy in ENERGIES {
            let entries = energy.entries(&mesh);
            let a = SparseSymmetric::from_entries(mesh.nodes.len(), &entries);
            let scale = a.entries().fold(0.0, |m: f64, e| m.max(e.2.abs()));
            for affine in [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z] {
                let values = mesh.nodes.iter().map(|x| 1.0 + 100.0 * affine.dot(*x));
                let u: Vec<f64> = values.collect();
                let residual = a.multiply(&u).iter().fold(0.0, |m: f64, r| m.max(r.abs()));
                assert!(
                    residual <= 1e-12 * scale,
                    "{energy:?}: A u = {residual:e}, |A| = {scale:e}"
                );
            }
            // Nothing else: A has rank nodes − 4.
            let n = mesh.nodes.len();
            let mut dense = faer::Mat::zeros(n, n);
            for (i, j, v) in a.entries() {
                dense[(i, j)] = v;
                dense[(j, i)] = v;
            }
            let values = dense.self_adjoint_eigenvalues(faer::Side::Lower).unwrap();
            assert!(
                values[3].abs() < 1e-10 * scale,
                "{energy:?}: {:e}",
                values[3]
            );
            assert!(
                values[4] > 1e-5 * scale,
                "{energy:?}: {:e} of {scale:e}",
                values[4]
            );
        }
    }

    /// E = ½ uᵀAu is half of Σ_f (area_f · jump of ∂u/∂n)²/m_f: worked by hand on two tets.
    #[test]
    fn the_energies_are_those_worked_by_hand() {
        let nodes = [
            [0.0; 3],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -2.0],
        ];
        let mesh = TetMesh {
            nodes: nodes.map(DVec3::from).to_vec(),
            tets: vec![[0, 1, 2, 3], [0, 2, 1, 4]],
        };
        // u is z above the face and 0 below: a jump of 1 over an area of ½, m = (1/6 + 1/3)/4.
        let u = [0.0, 0.0, 0.0, 1.0, 0.0];
        let [biharmonic, triharmonic] = ENERGIES.map(|energy| {
            let a = SparseSymmetric::from_entries(mesh.nodes.len(), &energy.entries(&mesh));
            a.multiply(&u)
                .iter()
                .zip(u)
                .map(|(a, u)| a * u)
                .sum::<f64>()
        });
        assert!((biharmonic - 0.25 / 0.125).abs() < 1e-14, "{biharmonic}");
        // The Laplacian is ½ / m = 4 in the face, its slopes 3 · 1 · 4 above (volume 1/6) and 3 · ½ · 4 below (1/3).
        let expected = 12.0 * 12.0 / 6.0 + 6.0 * 6.0 / 3.0;
        assert!((triharmonic - expected).abs() < 1e-12, "{triharmonic}");
    }
}
