//! A basis that knows elasticity: the handles' skin values extended into the depth as an elastic body would.
//!
//! For each handle h and each axis a, u minimises the linear elastic energy ½ uᵀ K u (that of
//! [`super::rest_stiffness`]) where the skin is moved by U_h e_a and the bones are fixed. The three fields are the
//! columns of N_h. On the skin the basis is the avatar's own, as sparse as it is there; below, tissue that is pressed
//! gives way sideways, as Poisson's ratio demands, which no scalar basis can do.

use super::Subspace;
use super::harmonic_extension::skin_value;
use super::linear_elasticity::{add_lower, rest_tangent, tet_stiffness};
use crate::basis::{HeldNodes, Role, Truncation};
use crate::math::{SparseFactor, SparseSymmetric};
use glam::{DMat3, DVec3};
use supple::Result;
use supple::internal::math::Rows;
use supple::model::Avatar;

/// Blocks smaller than this are rounding.
const ROUNDING: f64 = 1e-9;

/// The space of `avatar`'s handles with their skin values extended elastically. `depth` truncates the blocks of
/// nodes that are not skin by their size |N| = √(N : N/3), which is |U| of a scalar block.
///
/// # Errors
/// [`supple::Error::Solve`] where tissue hangs on neither skin nor bone.
pub fn elastic_extension(avatar: &Avatar, depth: Truncation) -> Result<Subspace> {
    let layer = &avatar.layer;
    let (mesh, embedding) = (&layer.mesh, &layer.skin_embedding);
    let held = HeldNodes::new(mesh, &layer.bone_of_node, embedding, &avatar.skin.measure);
    let mut entries = Vec::new();
    let mut coupling: Vec<(u32, u32, DMat3)> = Vec::new();
    let mut add =
        |i: u32, j: u32, block: DMat3| match (held.role[i as usize], held.role[j as usize]) {
            (Role::Free(r), Role::Free(c)) => add_lower(r, c, &block, &mut entries),
            (Role::Free(r), Role::Skin) => coupling.push((r, j, block)),
            _ => {}
        };
    for (tet, blocks) in mesh.tets.iter().zip(tet_stiffness(avatar)) {
        for (&i, blocks) in tet.iter().zip(&blocks) {
            for (&j, block) in tet.iter().zip(blocks) {
                add(i, j, *block);
            }
        }
    }
    // What is a Laplacian's 1 is the mean stiffness here, Pa.
    let tangent = rest_tangent(avatar, 0);
    let stiffness = (0..9).map(|i| tangent[i][i]).sum::<f64>() / 9.0;
    for &(vertex, area_by_length) in &held.soft {
        let row = embedding.row(vertex as usize);
        for &(i, share_i) in row {
            for &(j, share_j) in row {
                let diagonal = DVec3::splat(stiffness * area_by_length * share_i * share_j);
                add(i, j, DMat3::from_diagonal(diagonal));
            }
        }
    }
    let matrix = SparseSymmetric::from_entries(3 * held.free, &entries);
    drop(entries);
    let factor = SparseFactor::new(&matrix, "elastic extension")?;

    let skin_values = |h: usize| held.skin_values(move |v| skin_value(avatar, h, v));
    let load = |field: usize, b: &mut [f64]| {
        let (h, axis) = (field / 3, field % 3);
        let mut on_node = vec![0.0; mesh.nodes.len()];
        skin_values(h).for_each(|(node, u)| on_node[node as usize] = u);
        for &(column, node, block) in &coupling {
            let force = block.col(axis) * on_node[node as usize];
            (0..3).for_each(|i| b[3 * column as usize + i] -= force[i]);
        }
        for &(vertex, area_by_length) in &held.soft {
            let pull = stiffness * area_by_length * skin_value(avatar, h, vertex);
            for &(node, share) in embedding.row(vertex as usize) {
                if let Role::Free(column) = held.role[node as usize] {
                    b[3 * column as usize + axis] += pull * share;
                }
            }
        }
    };
    let handles = avatar.handles.len();
    let fields = factor.solve_each(3 * handles, load, |_, u| u.to_vec());

    let mut on_skin: Vec<Vec<(u32, DMat3)>> = vec![Vec::new(); mesh.nodes.len()];
    for h in 0..handles {
        for (node, u) in skin_values(h).filter(|(_, u)| *u != 0.0) {
            on_skin[node as usize].push((h as u32, DMat3::from_diagonal(DVec3::splat(u))));
        }
    }
    let block = |h: usize, column: u32| {
        let field = |axis: usize| DVec3::from_slice(&fields[3 * h + axis][3 * column as usize..]);
        DMat3::from_cols(field(0), field(1), field(2))
    };
    let at_node = |(role, on_skin): (&Role, Vec<(u32, DMat3)>)| match *role {
        Role::Bone(_) => Vec::new(),
        Role::Skin => on_skin,
        Role::Free(column) => (0..handles)
            .filter_map(|h| Some((h as u32, truncated(block(h, column), depth)?)))
            .collect(),
    };
    let nodes: Rows<(u32, DMat3)> = held.role.iter().zip(on_skin).map(at_node).collect();
    Subspace::new(avatar, avatar.handles.clone(), nodes)
}

/// N scaled as `depth` scales a value of its size; `None` where nothing is left.
fn truncated(n: DMat3, depth: Truncation) -> Option<DMat3> {
    let squares: f64 = n.to_cols_array().iter().map(|e| e * e).sum();
    let size = (squares / 3.0).sqrt();
    let kept = depth.apply(size);
    (kept > ROUNDING).then(|| n * (kept / size))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subspace::harmonic_extension;
    use crate::subspace::linear_elasticity::{free_columns, rest_stiffness};
    use crate::subspace::test_body::clamped_box;

    /// The field of handle h along `axis`, over the nodes that no bone holds.
    fn field(avatar: &Avatar, space: &Subspace, h: usize, axis: usize) -> Vec<f64> {
        let rows = space.nodes().iter().zip(&avatar.layer.bone_of_node);
        let at_node = |row: &[(u32, DMat3)]| {
            let block = row.iter().find(|e| e.0 as usize == h);
            block.map_or(DVec3::ZERO, |e| e.1.col(axis)).to_array()
        };
        rows.filter(|(_, bone)| bone.is_none())
            .flat_map(|(row, _)| at_node(row))
            .collect()
    }

    #[test]
    fn skin_is_kept_and_the_inside_is_in_equilibrium_with_the_least_energy() {
        let avatar = clamped_box([5, 4, 4], 0.4);
        let space = elastic_extension(&avatar, Truncation::OFF).unwrap();
        let harmonic = harmonic_extension(&avatar, Truncation::OFF).unwrap();
        let harmonic = Subspace::of_avatar(&harmonic).unwrap();
        for (own, row) in avatar.skin.basis.iter().zip(space.on_skin().iter()) {
            let own = own.iter().filter(|u| u.value != 0.0);
            assert!(own.clone().count() == row.len());
            for (own, block) in own.zip(row) {
                let expected = DMat3::from_diagonal(DVec3::splat(own.value));
                assert!(own.handle == block.handle && block.value == expected);
            }
        }
        let stiffness = rest_stiffness(&avatar);
        let (columns, _) = free_columns(&avatar.layer);
        let mut skin = vec![false; avatar.layer.mesh.nodes.len()];
        (avatar.layer.skin_embedding.entries().iter()).for_each(|e| skin[e.0 as usize] = true);
        let inside: Vec<usize> = (columns.iter().enumerate())
            .filter(|(n, column)| column.is_some() && !skin[*n])
            .flat_map(|(_, column)| column)
            .map(|c| *c as usize)
            .collect();
        assert!(inside.len() > 20);
        for h in 0..avatar.handles.len() {
            for axis in 0..3 {
                let u = field(&avatar, &space, h, axis);
                let forces = stiffness.multiply(&u);
                let largest = forces.iter().fold(0.0f64, |m, f| m.max(f.abs()));
                let rest = inside.iter().flat_map(|c| &forces[3 * c..3 * c + 3]);
                let rest = rest.fold(0.0f64, |m, f| m.max(f.abs()));
                // What is below ROUNDING was left out.
                assert!(
                    rest < 1e-8 * largest,
                    "handle {h}, {axis}: {rest:e} of {largest:e}"
                );
                let energy = |u: &[f64]| -> f64 {
                    stiffness
                        .multiply(u)
                        .iter()
                        .zip(u)
                        .map(|(f, u)| f * u)
                        .sum()
                };
                let more = energy(&field(&avatar, &harmonic, h, axis));
                assert!(
                    energy(&u) < 0.999 * more,
                    "handle {h}, {axis}: {} of {more}",
                    energy(&u)
                );
            }
        }
    }

    #[test]
    fn depth_truncates_below_the_skin_only() {
        let avatar = clamped_box([5, 4, 4], 0.4);
        let full = elastic_extension(&avatar, Truncation::OFF).unwrap();
        let sparse = elastic_extension(&avatar, Truncation::default()).unwrap();
        assert_eq!(full.on_skin(), sparse.on_skin());
        let [sparse, full] = [sparse, full].map(|space| space.nodes().entries().len());
        assert!(sparse < full, "{sparse} of {full}");
    }

    #[test]
    fn embedded_skin_moves_as_the_handles_say() {
        // The same vertices written as points of a tet: a second node of no share, so that they hold softly.
        let mut avatar = clamped_box([5, 4, 4], 0.4);
        let exact = elastic_extension(&avatar, Truncation::OFF)
            .unwrap()
            .on_skin();
        let embedding = avatar.layer.skin_embedding.iter();
        let other = |n: u32| if n > 100 { n - 1 } else { n + 1 };
        avatar.layer.skin_embedding = embedding
            .map(|row| [row[0], (other(row[0].0), 0.0)])
            .collect();
        let soft = elastic_extension(&avatar, Truncation::OFF)
            .unwrap()
            .on_skin();
        let mut worst: f64 = 0.0;
        for (exact, soft) in exact.iter().zip(soft.iter()) {
            for block in soft {
                let wanted = exact.iter().find(|b| b.handle == block.handle);
                let wanted = wanted.map_or(DMat3::ZERO, |b| b.value);
                let off = (block.value - wanted).to_cols_array();
                worst = off.iter().fold(worst, |m, o| m.max(o.abs()));
            }
        }
        // ℓ is a hundredth of an edge: what a handle changes by over ℓ, a few times where vertices share little area.
        assert!(worst > 0.0 && worst < 0.1, "{worst}");
    }
}
