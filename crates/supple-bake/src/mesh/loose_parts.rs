//! Parts of a mesh that the biharmonic energy leaves free.
//!
//! The energy sees faces only: a part that hangs on the rest by an edge or a corner may still be any
//! affine function. A lattice cut by skin and bones has a few such tets.

use crate::basis::{Constraints, interior_faces};
use crate::mesh::disjoint_sets::DisjointSets;
use glam::{DMat3, DVec3};
use std::collections::{BTreeSet, HashMap};
use supple::internal::math::symmetric_eigen;
use supple::model::TetMesh;

/// Strength of the Laplacian of a loose part relative to the biharmonic energy of a tet: enough for a
/// factorisation, too little to be felt across the corner it hangs on.
const FAINT: f64 = 1e-9;

/// Adds FAINT · vol^(1/3) ∇λ_i · ∇λ_j of `tets`, which compares with the energy: 1/m.
pub(crate) fn add_laplacian(mesh: &TetMesh, tets: &[u32], entries: &mut Vec<(u32, u32, f64)>) {
    for &t in tets {
        let (volume, gradients) = (
            mesh.volume(t as usize),
            mesh.barycentric_gradients(t as usize),
        );
        let scale = FAINT * volume.cbrt();
        for (&row, a) in mesh.tets[t as usize].iter().zip(gradients) {
            for (&column, b) in mesh.tets[t as usize].iter().zip(gradients) {
                if row >= column {
                    entries.push((row, column, scale * a.dot(b)));
                }
            }
        }
    }
}

/// Tets of the face-connected parts in which fixed nodes and constraints do not span the affine
/// functions, rising.
pub(crate) fn loose_tets(mesh: &TetMesh, fixed: &[bool], constraints: &Constraints) -> Vec<u32> {
    let part = face_connected_parts(mesh);
    let parts = mesh.tets.len();
    let mut anchors: Vec<BTreeSet<u32>> = vec![BTreeSet::new(); parts];
    let mut parts_of_node: HashMap<u32, BTreeSet<u32>> = HashMap::new();
    for (tet, &p) in mesh.tets.iter().zip(&part) {
        for &n in tet {
            parts_of_node.entry(n).or_default().insert(p);
            if fixed[n as usize] {
                anchors[p as usize].insert(n);
            }
        }
    }
    let mut points: Vec<Vec<DVec3>> = (anchors.iter())
        .map(|nodes| nodes.iter().map(|&n| mesh.nodes[n as usize]).collect())
        .collect();
    for row in constraints.iter() {
        let place = row
            .iter()
            .map(|&(n, share)| share * mesh.nodes[n as usize])
            .sum();
        let Some(&(first, _)) = row.first() else {
            continue;
        };
        let common = |p: &u32| {
            let mut others = row.iter();
            others.all(|(n, _)| parts_of_node.get(n).is_some_and(|parts| parts.contains(p)))
        };
        for p in parts_of_node
            .get(&first)
            .into_iter()
            .flatten()
            .filter(|p| common(p))
        {
            points[*p as usize].push(place);
        }
    }
    let spanned: Vec<bool> = points.iter().map(|p| span_space(p)).collect();
    (0..mesh.tets.len() as u32)
        .filter(|&t| !spanned[part[t as usize] as usize])
        .collect()
}

/// Whether four of `points` make a tet that is not flat, up to a millionth of their spread.
fn span_space(points: &[DVec3]) -> bool {
    if points.len() < 4 {
        return false;
    }
    let mean = points.iter().sum::<DVec3>() / points.len() as f64;
    let covariance = points.iter().fold(DMat3::ZERO, |sum, p| {
        let d = *p - mean;
        sum + DMat3::from_cols(d * d.x, d * d.y, d * d.z)
    });
    let (values, _) = symmetric_eigen(covariance);
    values.min_element() > 1e-6 * values.max_element()
}

/// The part of each tet; tets of one part hang together by faces.
fn face_connected_parts(mesh: &TetMesh) -> Vec<u32> {
    let mut sets = DisjointSets::new(mesh.tets.len());
    for [(a, _), (b, _)] in interior_faces(mesh) {
        sets.union(a as u32, b as u32);
    }
    (0..mesh.tets.len() as u32).map(|t| sets.find(t)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::{BasisEnergy, BiharmonicSystem};
    use crate::test_mesh::jittered_box;

    #[test]
    fn a_tet_hanging_on_a_corner_is_loose_and_does_no_harm() {
        let mut mesh = jittered_box([3, 3, 3], 0.01, 0.1, 41);
        let fixed: Vec<bool> = (0..64).map(|n| n < 16).collect();
        let constraints: Constraints = [[(50, 1.0)], [(60, 1.0)]].into_iter().collect();
        let before =
            BiharmonicSystem::new(&mesh, BasisEnergy::Biharmonic, &fixed, &constraints).unwrap();
        assert_eq!(before.loose_tets(), 0);
        let corner = mesh.nodes[63];
        mesh.nodes
            .extend([DVec3::X, DVec3::Y, DVec3::Z].map(|d| corner + 0.01 * d));
        mesh.tets.push([63, 64, 65, 66]);
        let fixed: Vec<bool> = (0..67).map(|n| n < 16).collect();
        let system =
            BiharmonicSystem::new(&mesh, BasisEnergy::Biharmonic, &fixed, &constraints).unwrap();
        assert_eq!(
            loose_tets(&mesh, &fixed, &constraints),
            [mesh.tets.len() as u32 - 1]
        );
        let (columns, alone) = (system.basis(), before.basis());
        assert!(system.linear_precision(&mesh, &columns) < 1e-9);
        for (with, without) in columns.iter().zip(&alone) {
            assert!((0..64).all(|n| (with[n] - without[n]).abs() < 1e-9));
            // It follows the corner it hangs on.
            assert!((64..67).all(|n| (with[n] - with[63]).abs() < 1e-6));
        }
    }
}
