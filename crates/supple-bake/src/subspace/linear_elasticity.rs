//! The layer as a linear elastic body at rest, with its bones fixed.
//!
//! ```text
//! K_ab = Σ_t V_t (∂N_a)ᵀ : C_t : (∂N_b)    m_a = ρ Σ_t V_t / 4
//! ```
//!
//! over the tets t with their tissue volumes V_t, C_t = ∂P/∂F at F = I. For isotropic tissue it is that of linear
//! elasticity, λ (∇·u)(∇·v) + 2 μ ε(u) : ε(v).

use crate::cubature::Tissue;
use crate::math::SparseSymmetric;
use glam::DMat3;
use supple::internal::cpu::Basis;
use supple::internal::math::{Mat9, par_map};
use supple::model::{Avatar, BasisEntry, SoftLayer};

/// C = ∂P/∂F at F = I in tet `t`, Pa.
pub(super) fn rest_tangent(avatar: &Avatar, t: usize) -> Mat9 {
    avatar.tissue_of_tet(t).tangent(DMat3::IDENTITY)
}

/// K_ab, N/m, of each tet between its nodes: `block[a][b]`.
pub(super) fn tet_stiffness(avatar: &Avatar) -> Vec<[[DMat3; 4]; 4]> {
    let SoftLayer {
        mesh,
        tissue_fraction,
        ..
    } = &avatar.layer;
    par_map(mesh.tets.len(), |t| {
        let volume = tissue_fraction[t] * mesh.volume(t);
        let tangent = rest_tangent(avatar, t);
        let hats = mesh.barycentric_gradients(t).map(|gradient| BasisEntry {
            handle: 0,
            value: 0.0,
            gradient,
        });
        let forces = hats.map(|hat| hat.stiffness(&tangent));
        forces.map(|force| hats.map(|hat| hat.contract(&force) * volume))
    })
}

/// Adds the lower triangle of a block between the columns `row` and `column` of nodes to `entries`.
pub(super) fn add_lower(row: u32, column: u32, block: &DMat3, entries: &mut Vec<(u32, u32, f64)>) {
    for j in 0..3 {
        for i in 0..3 {
            let (r, c) = (3 * row + i, 3 * column + j);
            if r >= c {
                entries.push((r, c, block.col(j as usize)[i as usize]));
            }
        }
    }
}

/// K, N/m, over the nodes that no bone holds, x, y and z of one after the other.
pub fn rest_stiffness(avatar: &Avatar) -> SparseSymmetric {
    let (columns, free) = free_columns(&avatar.layer);
    let mut entries = Vec::new();
    for (tet, blocks) in avatar.layer.mesh.tets.iter().zip(tet_stiffness(avatar)) {
        let own = tet.map(|n| columns[n as usize]);
        for (row, blocks) in own.iter().zip(&blocks) {
            for (column, block) in own.iter().zip(blocks) {
                if let (Some(r), Some(c)) = (*row, *column) {
                    add_lower(r, c, block, &mut entries);
                }
            }
        }
    }
    SparseSymmetric::from_entries(3 * free, &entries)
}

/// m of each node that no bone holds, kg.
pub fn lumped_mass(avatar: &Avatar) -> Vec<f64> {
    let layer = &avatar.layer;
    let tissue = Tissue {
        mesh: &layer.mesh,
        fraction: &layer.tissue_fraction,
    };
    let nodal = tissue.nodal_volumes();
    let nodes = nodal.iter().zip(&layer.bone_of_node);
    nodes
        .filter(|(_, bone)| bone.is_none())
        .map(|(volume, _)| avatar.density * volume)
        .collect()
}

/// The place of each node among those that no bone holds, and their number.
pub(super) fn free_columns(layer: &SoftLayer) -> (Vec<Option<u32>>, usize) {
    let mut free = 0;
    let column = |bone: &Option<u32>| match bone {
        Some(_) => None,
        None => {
            free += 1;
            Some(free - 1)
        }
    };
    let columns = layer.bone_of_node.iter().map(column).collect();
    (columns, free as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subspace::test_body::clamped_box;
    use glam::DVec3;
    use supple::internal::math::Random;
    use supple::material::StableNeoHookean;

    /// ½ ∫ λ (∇·u)² + 2 μ ε : ε of a field on the nodes, summed tet by tet.
    fn strain_energy(avatar: &Avatar, material: &StableNeoHookean, u: &[DVec3]) -> f64 {
        let (mu, lambda) = material.lame();
        let mesh = &avatar.layer.mesh;
        let of_tet = |t: usize| {
            let mut gradient = DMat3::ZERO;
            for (&n, g) in mesh.tets[t].iter().zip(mesh.barycentric_gradients(t)) {
                let u = u[n as usize];
                gradient += DMat3::from_cols(u * g.x, u * g.y, u * g.z);
            }
            let strain = (gradient + gradient.transpose()) * 0.5;
            let squares: f64 = strain.to_cols_array().iter().map(|e| e * e).sum();
            let trace = strain.x_axis.x + strain.y_axis.y + strain.z_axis.z;
            let volume = avatar.layer.tissue_fraction[t] * mesh.volume(t);
            volume * (0.5 * lambda * trace * trace + mu * squares)
        };
        (0..mesh.tets.len()).map(of_tet).sum()
    }

    #[test]
    fn stiffness_is_that_of_linear_elasticity() {
        let avatar = clamped_box([4, 3, 3], 0.2);
        let material = StableNeoHookean {
            youngs_modulus: 30e3,
            poissons_ratio: 0.2,
        };
        let stiffness = rest_stiffness(&avatar);
        let mut random = Random::new(5);
        let held = &avatar.layer.bone_of_node;
        let nodes: Vec<DVec3> = (held.iter())
            .map(|bone| match bone {
                Some(_) => DVec3::ZERO,
                None => random.vector(1e-3),
            })
            .collect();
        let free = nodes.iter().zip(held).filter(|(_, bone)| bone.is_none());
        let x: Vec<f64> = free.flat_map(|(u, _)| u.to_array()).collect();
        let product: f64 = stiffness
            .multiply(&x)
            .iter()
            .zip(&x)
            .map(|(k, x)| k * x)
            .sum();
        let expected = strain_energy(&avatar, &material, &nodes);
        approx::assert_relative_eq!(0.5 * product, expected, max_relative = 1e-12);
    }

    #[test]
    fn lumped_mass_is_that_of_the_tissue_less_the_bones_share() {
        let avatar = clamped_box([4, 3, 3], 0.2);
        let whole: f64 = (avatar.layer.tissue_fraction.iter().enumerate())
            .map(|(t, f)| avatar.density * f * avatar.layer.mesh.volume(t))
            .sum();
        let mass: f64 = lumped_mass(&avatar).iter().sum();
        // A layer of four: the bone's nodes hold about an eighth.
        assert!(mass < whole && mass > 0.75 * whole, "{mass} of {whole}");
    }
}
