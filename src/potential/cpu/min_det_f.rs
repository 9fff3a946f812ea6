//! The smallest det F over all tets: whether the tissue is inverted anywhere, and how near it is.

use crate::math::par_map;
use crate::model::{Avatar, State, TetMesh};
use glam::{DMat3, DVec3};

/// min det F over the tets of the layer, with F = I + Σ_n u_n ∇λ_nᵀ and u_n = Σ_h U_h φ_h + Σ_awake N_h φ_h (0 at nodes
/// that a bone holds). Cubature points alone miss the worst tet. 1 where there is no tet, NaN where a tet's is.
pub fn min_det_f(avatar: &Avatar, state: &State) -> f64 {
    let layer = &avatar.layer;
    let of_node = |n: usize| {
        if layer.bone_of_node[n].is_some() {
            return DVec3::ZERO;
        }
        let coarse = layer.basis.row(n).iter();
        let coarse: DVec3 = coarse.map(|&(h, u)| u * state.handles[h as usize]).sum();
        if state.awake.is_empty() {
            return coarse;
        }
        let fine = avatar.fine.nodes.row(n).iter().filter_map(|(handle, n)| {
            let phi = avatar.fine_displacement(state, *handle)?;
            Some(DMat3::from_cols_array(&n.map(f64::from)) * phi)
        });
        coarse + fine.sum::<DVec3>()
    };
    let nodes: Vec<DVec3> = (0..layer.basis.len()).map(of_node).collect();
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
