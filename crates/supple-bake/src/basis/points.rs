//! From values at the layer's nodes to values at cubature points and skin vertices.

use glam::DVec3;
use supple::internal::math::Rows;
use supple::model::{BasisEntry, SkinWeight, TetMesh};

/// Handles of each tet of `tets`: U at the centroid (the mean of its nodes) and the tet's constant
/// ∇U = Σ U_n ∇λ_n, from `basis`, the handles (rising) of each node.
pub(crate) fn basis_at_tets(
    mesh: &TetMesh,
    basis: &Rows<(u32, f64)>,
    tets: &[u32],
) -> Rows<BasisEntry> {
    let at_tet = |&t: &u32| {
        let gradients = mesh.barycentric_gradients(t as usize);
        let mut row: Vec<BasisEntry> = Vec::new();
        for (&node, gradient) in mesh.tets[t as usize].iter().zip(gradients) {
            for &(handle, u) in basis.row(node as usize) {
                add(&mut row, handle, u / 4.0, u * gradient);
            }
        }
        row
    };
    tets.iter().map(at_tet).collect()
}

/// Handles of each skin vertex: U embedded in the nodes, no gradient.
pub(crate) fn basis_on_skin(
    embedding: &Rows<(u32, f64)>,
    basis: &Rows<(u32, f64)>,
) -> Rows<BasisEntry> {
    let at_vertex = |nodes: &[(u32, f64)]| {
        let mut row: Vec<BasisEntry> = Vec::new();
        for &(node, share) in nodes {
            for &(handle, u) in basis.row(node as usize) {
                add(&mut row, handle, share * u, DVec3::ZERO);
            }
        }
        row.retain(|u| u.value != 0.0);
        row
    };
    embedding.iter().map(at_vertex).collect()
}

/// Handles of points that follow others: `shares` of `basis`.
pub(crate) fn rows_through(
    shares: &Rows<(u32, f64)>,
    basis: &Rows<BasisEntry>,
) -> Rows<BasisEntry> {
    let at_point = |followed: &[(u32, f64)]| {
        let mut row: Vec<BasisEntry> = Vec::new();
        for &(point, share) in followed {
            for u in basis.row(point as usize) {
                add(&mut row, u.handle, share * u.value, share * u.gradient);
            }
        }
        row
    };
    shares.iter().map(at_point).collect()
}

/// Bones of each tet of `tets`: the mean of its nodes' weights, `most` bones at most.
pub(crate) fn skinning_at_tets(
    mesh: &TetMesh,
    skinning: &Rows<SkinWeight>,
    tets: &[u32],
    most: usize,
) -> Rows<SkinWeight> {
    let at_tet = |&t: &u32| {
        let mut row: Vec<SkinWeight> = Vec::new();
        for &node in &mesh.tets[t as usize] {
            for w in skinning.row(node as usize) {
                match row.iter_mut().find(|r| r.bone == w.bone) {
                    Some(r) => r.weight += w.weight / 4.0,
                    None => row.push(SkinWeight {
                        bone: w.bone,
                        weight: w.weight / 4.0,
                    }),
                }
            }
        }
        largest_weights(row, most)
    };
    tets.iter().map(at_tet).collect()
}

/// The `most` largest weights above 1e-3, scaled to sum to 1, by rising bone.
pub(crate) fn largest_weights(mut row: Vec<SkinWeight>, most: usize) -> Vec<SkinWeight> {
    row.sort_by(|a, b| b.weight.total_cmp(&a.weight).then(a.bone.cmp(&b.bone)));
    row.truncate(most.max(1));
    row.retain(|w| w.weight > 1e-3);
    let sum: f64 = row.iter().map(|w| w.weight).sum();
    row.iter_mut().for_each(|w| w.weight /= sum);
    row.sort_by_key(|w| w.bone);
    row
}

/// Adds to the entry of `handle`, keeping handles rising.
fn add(row: &mut Vec<BasisEntry>, handle: u32, value: f64, gradient: DVec3) {
    match row.binary_search_by_key(&handle, |u| u.handle) {
        Ok(at) => {
            row[at].value += value;
            row[at].gradient += gradient;
        }
        Err(at) => row.insert(
            at,
            BasisEntry {
                handle,
                value,
                gradient,
            },
        ),
    }
}
