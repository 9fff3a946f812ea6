//! The smallest det F over all tets: whether the tissue is inverted anywhere, and how near it is.

use crate::math::par_map;
use crate::model::{SoftLayer, State, TetMesh};
use glam::{DMat3, DVec3};

/// min det F over the tets of `layer`, with F = I + Σ_n u_n ∇λ_nᵀ and u_n = Σ_h U_h φ_h (0 at nodes that a
/// bone holds). Cubature points alone miss the worst tet. 1 where there is no tet, NaN where a tet's is.
pub fn min_det_f(layer: &SoftLayer, state: &State) -> f64 {
    let nodes: Vec<DVec3> = layer
        .basis
        .iter()
        .zip(&layer.bone_of_node)
        .map(|(row, bone)| match bone {
            Some(_) => DVec3::ZERO,
            None => row
                .iter()
                .map(|&(h, u)| u * state.handles[h as usize])
                .sum(),
        })
        .collect();
    min_det_f_at_nodes(&layer.mesh, &nodes)
}

/// The same of a displacement u_n, m, given at each node.
pub fn min_det_f_at_nodes(mesh: &TetMesh, displacement: &[DVec3]) -> f64 {
    let determinants = par_map(mesh.tets.len(), |t| {
        let gradients = mesh.barycentric_gradients(t);
        let mut f = DMat3::IDENTITY;
        for (&n, g) in mesh.tets[t].iter().zip(gradients) {
            let u = displacement[n as usize];
            f += DMat3::from_cols(u * g.x, u * g.y, u * g.z);
        }
        f.determinant()
    });
    // f64::min would drop a NaN.
    let smaller = |a: f64, b: f64| if b < a || b.is_nan() { b } else { a };
    determinants.into_iter().reduce(smaller).unwrap_or(1.0)
}
