//! A basis that knows elasticity: the handles' skin values extended into the depth as an elastic body would.
//!
//! For each handle h and each axis a, u minimises the linear elastic energy ½ uᵀ K u (that of
//! [`super::rest_stiffness`]) where the skin is moved by U_h e_a and the bones are fixed. The three fields are the
//! columns of N_h. On the skin the basis is the avatar's own, as sparse as it is there; below, tissue that is pressed
//! gives way sideways, as Poisson's ratio demands, which no scalar basis can do.

use super::Subspace;
use super::linear_elasticity::{add_lower, rest_tangent, tet_stiffness};
use crate::basis::{HeldNodes, Role, Truncation};
use crate::math::{SparseFactor, SparseSymmetric};
use glam::{DMat3, DVec3};
use std::collections::BTreeMap;
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
    let mut on_skin = vec![Vec::new(); avatar.handles.len()];
    let tissue = avatar.skin.basis.iter().take(avatar.tissue_vertices());
    for (v, row) in (0..).zip(tissue) {
        for u in row.iter().filter(|u| u.value != 0.0) {
            on_skin[u.handle as usize].push((v, u.value));
        }
    }
    let columns = ElasticExtension::new(avatar)?.columns(&on_skin, depth);
    let nodes = by_node(avatar.layer.mesh.nodes.len(), &columns);
    Subspace::new(avatar, avatar.handles.clone(), nodes)
}

/// Columns of (node, N) as a row of (column, N) for each node.
pub(crate) fn by_node(nodes: usize, columns: &[Vec<(u32, DMat3)>]) -> Rows<(u32, DMat3)> {
    let mut rows = vec![Vec::new(); nodes];
    for (h, column) in (0..).zip(columns) {
        (column.iter()).for_each(|&(node, block)| rows[node as usize].push((h, block)));
    }
    rows.into_iter().collect()
}

/// The factored system of an avatar's layer whose skin is moved and whose bones stand.
pub(crate) struct ElasticExtension<'a> {
    embedding: &'a Rows<(u32, f64)>,
    held: HeldNodes,
    /// Area/ℓ of each skin vertex that holds softly, m.
    soft: Vec<Option<f64>>,
    /// (free column, K) of each node that is skin: what moves the free one where the skin's moves.
    coupling: Rows<(u32, DMat3)>,
    /// What is a Laplacian's 1 is the mean stiffness here, Pa.
    stiffness: f64,
    factor: SparseFactor,
}

impl<'a> ElasticExtension<'a> {
    /// Factors K of `avatar` over the nodes that neither skin nor bone holds.
    ///
    /// # Errors
    /// [`supple::Error::Solve`] where tissue hangs on neither skin nor bone.
    pub fn new(avatar: &'a Avatar) -> Result<Self> {
        let layer = &avatar.layer;
        let (mesh, embedding) = (&layer.mesh, &layer.skin_embedding);
        let held = HeldNodes::new(mesh, &layer.bone_of_node, embedding, &avatar.skin.measure);
        let mut entries = Vec::new();
        let mut coupling: Vec<Vec<(u32, DMat3)>> = vec![Vec::new(); mesh.nodes.len()];
        let mut add =
            |i: u32, j: u32, block: DMat3| match (held.role[i as usize], held.role[j as usize]) {
                (Role::Free(r), Role::Free(c)) => add_lower(r, c, &block, &mut entries),
                (Role::Free(r), Role::Skin) => coupling[j as usize].push((r, block)),
                _ => {}
            };
        for (tet, blocks) in mesh.tets.iter().zip(tet_stiffness(avatar)) {
            for (&i, blocks) in tet.iter().zip(&blocks) {
                for (&j, block) in tet.iter().zip(blocks) {
                    add(i, j, *block);
                }
            }
        }
        let tangent = rest_tangent(avatar, 0);
        let stiffness = (0..9).map(|i| tangent[i][i]).sum::<f64>() / 9.0;
        let mut soft = vec![None; embedding.len()];
        for &(vertex, area_by_length) in &held.soft {
            soft[vertex as usize] = Some(area_by_length);
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
        Ok(Self {
            factor: SparseFactor::new(&matrix, "elastic extension")?,
            coupling: coupling.into_iter().collect(),
            embedding,
            held,
            soft,
            stiffness,
        })
    }

    /// N of each column, whose values U on the skin are given as (vertex, U), at the nodes where it is not 0: (node, N),
    /// nodes rising. `depth` truncates what is not skin.
    pub fn columns(
        &self,
        on_skin: &[Vec<(u32, f64)>],
        depth: Truncation,
    ) -> Vec<Vec<(u32, DMat3)>> {
        let load = |h: usize, b: &mut [f64]| self.load(&on_skin[h], b);
        let blocks = |h: usize, x: &[f64]| self.blocks(&on_skin[h], x, depth);
        self.factor.solve_sets(on_skin.len(), 3, load, blocks)
    }

    /// −K_is U e_a for the three axes a, one after the other.
    fn load(&self, on_skin: &[(u32, f64)], b: &mut [f64]) {
        let n = 3 * self.held.free;
        for (node, u) in self.skin_nodes(on_skin) {
            for &(column, block) in self.coupling.row(node as usize) {
                for axis in 0..3 {
                    let force = block.col(axis) * u;
                    let at = axis * n + 3 * column as usize;
                    (0..3).for_each(|i| b[at + i] -= force[i]);
                }
            }
        }
        for &(vertex, u) in on_skin {
            let Some(area_by_length) = self.soft[vertex as usize] else {
                continue;
            };
            let pull = self.stiffness * area_by_length * u;
            for &(node, share) in self.embedding.row(vertex as usize) {
                if let Role::Free(column) = self.held.role[node as usize] {
                    for axis in 0..3 {
                        b[axis * n + 3 * column as usize + axis] += pull * share;
                    }
                }
            }
        }
    }

    /// The blocks of a column from its solution `x`.
    fn blocks(&self, on_skin: &[(u32, f64)], x: &[f64], depth: Truncation) -> Vec<(u32, DMat3)> {
        let n = 3 * self.held.free;
        let on_skin: Vec<(u32, f64)> = self.skin_nodes(on_skin).collect();
        let at_node = |(node, role): (u32, &Role)| {
            let block = match *role {
                Role::Bone(_) => None,
                Role::Skin => {
                    let at = on_skin.binary_search_by_key(&node, |e| e.0).ok()?;
                    Some(DMat3::from_diagonal(DVec3::splat(on_skin[at].1)))
                }
                Role::Free(column) => {
                    let at = 3 * column as usize;
                    let along = |axis: usize| DVec3::from_slice(&x[axis * n + at..]);
                    truncated(DMat3::from_cols(along(0), along(1), along(2)), depth)
                }
            };
            Some((node, block?))
        };
        (0..).zip(&self.held.role).filter_map(at_node).collect()
    }

    /// (node, U) at the nodes that are skin and where `on_skin` is given, nodes rising: the mean over a node's vertices.
    fn skin_nodes(&self, on_skin: &[(u32, f64)]) -> impl Iterator<Item = (u32, f64)> {
        let mut sums = BTreeMap::new();
        for &(vertex, u) in on_skin {
            if let [(node, _)] = *self.embedding.row(vertex as usize)
                && self.held.role[node as usize] == Role::Skin
            {
                *sums.entry(node).or_insert(0.0) += u;
            }
        }
        let mean = |(node, sum): (u32, f64)| {
            let vertices = self.held.vertices_of_node[&node].len();
            (node, sum / vertices as f64)
        };
        sums.into_iter().map(mean)
    }
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
