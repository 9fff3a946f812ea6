//! The biharmonic energy of a tet mesh in its facet form.

use crate::model::TetMesh;

/// The squared jump of ∂u/∂n over interior faces, as entries (row ≥ column) of
///
/// A = Σ_f (1/m_f) r_f r_fᵀ,  m_f = (vol₁ + vol₂)/4,
/// r_f\[j\] = Σ over the two tets t of f of 3 vol_t ∇λ_{t,opp(f)} · ∇λ_{t,j}.
///
/// This is libigl's `biharmonic_coordinates` with k = 2; the vertex form printed in the paper
/// carries an erratum. Its null space is the affine functions, on every part of the mesh whose
/// tets hang together by faces. Unit: 1/m.
pub fn biharmonic_energy(mesh: &TetMesh) -> Vec<(u32, u32, f64)> {
    let mut entries = Vec::with_capacity(mesh.tets.len() * 32);
    for [first, second] in interior_faces(mesh) {
        let mut nodes = [0u32; 5];
        let mut jump = [0.0; 5];
        let mut volume = 0.0;
        for (side, (tet, opposite)) in [first, second].into_iter().enumerate() {
            let gradients = mesh.barycentric_gradients(tet);
            let tet_volume = mesh.volume(tet);
            volume += tet_volume;
            for (corner, &node) in mesh.tets[tet].iter().enumerate() {
                // Slots 0..4 are the first tet's corners; 4 is the second's own corner.
                let slot = match side {
                    0 => corner,
                    _ => nodes[..4].iter().position(|&n| n == node).unwrap_or(4),
                };
                nodes[slot] = node;
                jump[slot] += 3.0 * tet_volume * gradients[opposite].dot(gradients[corner]);
            }
        }
        let mass = volume / 4.0;
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

/// The faces between two tets: (tet, opposite corner) of each side, by rising nodes. Where a lattice
/// branches, several tets lie on one side of a face: each is paired with each of the other side.
pub(super) fn interior_faces(mesh: &TetMesh) -> Vec<[(usize, usize); 2]> {
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
    use crate::bake::test_mesh::jittered_box;
    use crate::math::SparseSymmetric;
    use glam::DVec3;

    fn energy(mesh: &TetMesh) -> SparseSymmetric {
        SparseSymmetric::from_entries(mesh.nodes.len(), &biharmonic_energy(mesh))
    }

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
        let a = energy(&mesh);
        let scale = a.entries().fold(0.0, |m: f64, e| m.max(e.2.abs()));
        for affine in [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z] {
            let u: Vec<f64> = mesh
                .nodes
                .iter()
                .map(|x| 1.0 + 100.0 * affine.dot(*x))
                .collect();
            let residual = a.multiply(&u).iter().fold(0.0, |m: f64, r| m.max(r.abs()));
            assert!(
                residual <= 1e-12 * scale,
                "A u = {residual:e}, |A| = {scale:e}"
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
        assert!(values[3].abs() < 1e-10 * scale, "{:e}", values[3]);
        assert!(values[4] > 1e-4 * scale, "{:e} of {scale:e}", values[4]);
    }

    /// E = ½ uᵀAu is half of Σ_f (area_f · jump of ∂u/∂n)²/m_f: worked by hand on two tets.
    #[test]
    fn the_energy_is_the_squared_jump_over_the_facets_mass() {
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
        let energy: f64 = energy(&mesh)
            .multiply(&u)
            .iter()
            .zip(u)
            .map(|(a, u)| a * u)
            .sum();
        assert!((energy - 0.25 / 0.125).abs() < 1e-14, "{energy}");
    }
}
