//! A space for the tissue's displacement, and an avatar that moves in it.

use crate::full_space::without_tissue;
use crate::math::NearestPoint;
use glam::{DMat3, DVec3};
use std::sync::Arc;
use supple::internal::cpu::{GeneralBasis, min_det_f_at_nodes};
use supple::internal::math::{Rows, par_map};
use supple::model::{Avatar, State, TetMesh};
use supple::potential::CpuPotential;
use supple::sim::{Settings, Simulation};
use supple::{Error, Result};

/// Blocks N_h of a node: u = Σ_h N_h φ_h, without unit, handles rising.
type NodeBlocks = Rows<(u32, DMat3)>;

/// A space for the tissue's displacement: an avatar, and what its handles do at each node of its layer.
#[derive(Clone, Debug)]
pub struct Subspace {
    /// The avatar, with the handles of this space. It has no scalar basis: its own rows are empty.
    avatar: Arc<Avatar>,
    nodes: NodeBlocks,
    /// The tet whose centroid each cubature point is.
    tets: Vec<u32>,
}

impl Subspace {
    /// `avatar` in another space: `nodes` are the blocks (handle, N) of each node of its layer, `handles` the rest
    /// positions of the handles, m.
    ///
    /// # Errors
    /// [`Error::Invalid`] where a row is missing, a node that a bone holds has a block, a block names a handle that
    /// is not there, handles do not rise, a value is not finite, or a cubature point is no tet's centroid.
    pub fn new(avatar: &Avatar, handles: Vec<DVec3>, nodes: NodeBlocks) -> Result<Self> {
        let layer = &avatar.layer;
        nodes.validate("nodes", layer.mesh.nodes.len())?;
        let problem = |problem: &str| Err(Error::invalid("nodes", problem));
        for (row, bone) in nodes.iter().zip(&layer.bone_of_node) {
            if bone.is_some() && !row.is_empty() {
                return problem("a node that a bone holds must not move");
            }
            if row.iter().any(|e| e.0 as usize >= handles.len()) {
                return problem("names a handle that is not there");
            }
            if !row.is_sorted_by(|a, b| a.0 < b.0) {
                return problem("handles of a node must rise");
            }
            if row.iter().any(|e| !e.1.is_finite()) {
                return problem("holds a value that is not finite");
            }
        }
        let tets = tets_of_points(&layer.mesh, &avatar.cubature.position)?;
        Ok(Self {
            avatar: Arc::new(Avatar {
                name: avatar.name.clone(),
                handles,
                ..without_tissue(avatar)
            }),
            nodes,
            tets,
        })
    }

    /// The space that `avatar` has already, block by block.
    ///
    /// # Errors
    /// As [`Subspace::new`].
    pub fn of_avatar(avatar: &Avatar) -> Result<Self> {
        let scaled = |&(h, u): &(u32, f64)| (h, DMat3::from_diagonal(DVec3::splat(u)));
        let held = &avatar.layer.bone_of_node;
        let rows = avatar.layer.basis.iter().zip(held);
        let rows = rows.map(|(row, bone)| row.iter().filter(|_| bone.is_none()).map(scaled));
        Self::new(avatar, avatar.handles.clone(), rows.collect())
    }

    /// The avatar, with as many handles as this space has.
    pub fn avatar(&self) -> &Arc<Avatar> {
        &self.avatar
    }

    /// Blocks of each node.
    pub fn nodes(&self) -> &Rows<(u32, DMat3)> {
        &self.nodes
    }

    /// Blocks of the cubature points.
    pub fn at_points(&self) -> Rows<GeneralBasis> {
        self.at_tets(&self.tets)
    }

    /// Blocks of each tet of `tets`: N at the centroid (the mean of its nodes) and the tet's constant
    /// ∂N/∂X_l = Σ N_n ∂λ_n/∂X_l, 1/m.
    pub fn at_tets(&self, tets: &[u32]) -> Rows<GeneralBasis> {
        let mesh = &self.avatar.layer.mesh;
        let at_tet = |i: usize| {
            let t = tets[i] as usize;
            let corners = mesh.tets[t].iter().zip(mesh.barycentric_gradients(t));
            self.sum(corners.map(|(&n, gradient)| (n, 0.25, gradient)))
        };
        par_map(tets.len(), at_tet).into_iter().collect()
    }

    /// Blocks of the skin vertices; they need no gradient.
    pub fn on_skin(&self) -> Rows<GeneralBasis> {
        let layer = &self.avatar.layer;
        let on_tissue = |nodes: &[(u32, f64)]| {
            self.sum(nodes.iter().map(|&(n, share)| (n, share, DVec3::ZERO)))
        };
        let mut rows: Rows<GeneralBasis> = layer.skin_embedding.iter().map(on_tissue).collect();
        for followed in self.avatar.attached.iter() {
            let nodes = followed.iter().flat_map(|&(v, share)| {
                let nodes = layer.skin_embedding.row(v as usize).iter();
                nodes.map(move |&(n, part)| (n, share * part, DVec3::ZERO))
            });
            rows.push(self.sum(nodes));
        }
        rows
    }

    /// Σ share N_n and Σ N_n gradient_n over (node n, share, gradient), handles rising.
    fn sum(&self, nodes: impl Iterator<Item = (u32, f64, DVec3)>) -> Vec<GeneralBasis> {
        let mut row: Vec<GeneralBasis> = Vec::new();
        for (node, share, gradient) in nodes {
            for &(handle, n) in self.nodes.row(node as usize) {
                let at = row.partition_point(|b| b.handle < handle);
                if row.get(at).is_none_or(|b| b.handle != handle) {
                    let empty = GeneralBasis {
                        handle,
                        value: DMat3::ZERO,
                        gradient: [DMat3::ZERO; 3],
                    };
                    row.insert(at, empty);
                }
                row[at].value += n * share;
                for axis in 0..3 {
                    row[at].gradient[axis] += n * gradient[axis];
                }
            }
        }
        row
    }

    /// The f64 evaluation in this space; as [`CpuPotential::new`].
    ///
    /// # Errors
    /// As [`CpuPotential::with_basis`].
    pub fn reference(&self, instances: usize) -> Result<CpuPotential<GeneralBasis>> {
        CpuPotential::with_basis(
            self.avatar.clone(),
            &self.at_points(),
            &self.on_skin(),
            instances,
        )
    }

    /// A simulation in this space.
    ///
    /// # Errors
    /// As [`Subspace::reference`] and [`Simulation::new`].
    pub fn simulation(
        &self,
        instances: usize,
        settings: Settings,
    ) -> Result<Simulation<CpuPotential<GeneralBasis>>> {
        let potential = self.reference(instances)?;
        Simulation::new(&self.avatar, potential, settings)
    }

    /// Unposed displacement of each node, m.
    ///
    /// # Errors
    /// [`Error::Invalid`] where `state` has another number of handles.
    pub fn displacement(&self, state: &State) -> Result<Vec<DVec3>> {
        if state.space() != self.avatar.space() {
            let problem = "has not this space's numbers of bones and handles";
            return Err(Error::invalid("state", problem));
        }
        let at_node = |row: &[(u32, DMat3)]| {
            let parts = row.iter().map(|(h, n)| *n * state.handles[*h as usize]);
            parts.sum()
        };
        Ok(self.nodes.iter().map(at_node).collect())
    }

    /// Unposed displacement of each skin vertex, m.
    ///
    /// # Errors
    /// As [`Subspace::displacement`].
    pub fn skin_displacement(&self, state: &State) -> Result<Vec<DVec3>> {
        let nodes = self.displacement(state)?;
        let layer = &self.avatar.layer;
        let gather = |row: &[(u32, f64)], from: &[DVec3]| -> DVec3 {
            row.iter().map(|&(i, share)| share * from[i as usize]).sum()
        };
        let on_tissue = layer.skin_embedding.iter().map(|row| gather(row, &nodes));
        let mut skin: Vec<DVec3> = on_tissue.collect();
        let attached = self.avatar.attached.iter().map(|row| gather(row, &skin));
        let attached: Vec<DVec3> = attached.collect();
        skin.extend(attached);
        Ok(skin)
    }

    /// Smallest det F over all tets of the layer; see [`supple::internal::cpu::min_det_f`].
    ///
    /// # Errors
    /// As [`Subspace::displacement`].
    pub fn min_det_f(&self, state: &State) -> Result<f64> {
        let nodes = self.displacement(state)?;
        Ok(min_det_f_at_nodes(&self.avatar.layer.mesh, &nodes))
    }

    /// Handles of a cubature point, on average.
    pub fn entries_per_point(&self) -> f64 {
        let rows = self.at_points();
        rows.entries().len() as f64 / rows.len().max(1) as f64
    }
}

/// The tet whose centroid each of `points` is.
pub(super) fn tets_of_points(mesh: &TetMesh, points: &[DVec3]) -> Result<Vec<u32>> {
    let centroids: Vec<DVec3> = (0..mesh.tets.len()).map(|t| mesh.centroid(t)).collect();
    let nearest = NearestPoint::new(&centroids);
    let tets = par_map(points.len(), |i| {
        let found = nearest.nearest(points[i]);
        // A baked centroid is the same sum of the same corners.
        found.filter(|(_, distance)| *distance == 0.0)
    });
    let tets: Option<Vec<u32>> = tets.into_iter().map(|t| t.map(|t| t.0)).collect();
    tets.ok_or_else(|| Error::invalid("cubature", "a point is no tet's centroid: bake it again"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::subspace::test_body::clamped_box;

    #[test]
    fn the_avatars_own_space_is_its_own_basis() {
        let avatar = clamped_box([4, 3, 3], 0.4);
        let space = Subspace::of_avatar(&avatar).unwrap();
        for (own, rows) in [
            (&avatar.cubature.basis, space.at_points()),
            (&avatar.skin.basis, space.on_skin()),
        ] {
            for (own, row) in own.iter().zip(rows.iter()) {
                for block in row {
                    let entry = own.iter().find(|u| u.handle == block.handle);
                    let expected = GeneralBasis::from(entry.unwrap());
                    assert!((block.value - expected.value).abs_diff_eq(DMat3::ZERO, 1e-14));
                    for (a, b) in block.gradient.iter().zip(expected.gradient) {
                        assert!((*a - b).abs_diff_eq(DMat3::ZERO, 1e-11));
                    }
                }
                let held = own.iter().filter(|u| u.value != 0.0).count();
                assert!(row.len() >= held);
            }
        }
        let mut state = avatar.rest_state();
        (state.handles.iter_mut().enumerate())
            .for_each(|(h, phi)| *phi = 1e-3 * DVec3::new(h as f64, 2.0, -1.0));
        let own = supple::internal::cpu::min_det_f(&avatar, &state);
        approx::assert_relative_eq!(space.min_det_f(&state).unwrap(), own, epsilon = 1e-13);
        assert!(own < 1.0);
    }

    #[test]
    fn unusable_blocks_are_refused_by_name() {
        let avatar = clamped_box([3, 3, 2], 0.4);
        let nodes = avatar.layer.mesh.nodes.len();
        let row = |n: usize, row: &[(u32, f64)]| -> String {
            let blocks = |&(h, u): &(u32, f64)| (h, DMat3::from_diagonal(DVec3::splat(u)));
            let rows: Rows<(u32, DMat3)> = (0..nodes)
                .map(|k| {
                    row.iter()
                        .filter(|_| k == n)
                        .map(blocks)
                        .collect::<Vec<_>>()
                })
                .collect();
            let made = Subspace::new(&avatar, vec![DVec3::ZERO; 2], rows);
            made.map_or_else(|e| e.to_string(), |_| "made".into())
        };
        let free = nodes - 1;
        assert_eq!(row(free, &[(0, 1.0), (1, 0.5)]), "made");
        assert!(row(0, &[(0, 1.0)]).contains("bone"));
        assert!(row(free, &[(2, 1.0)]).contains("not there"));
        assert!(row(free, &[(1, 1.0), (0, 1.0)]).contains("rise"));
        assert!(row(free, &[(0, f64::NAN)]).contains("finite"));
        let mut moved = avatar.clone();
        moved.cubature.position[0] += DVec3::X;
        let error = Subspace::of_avatar(&moved).unwrap_err().to_string();
        assert!(error.contains("cubature"), "{error}");
    }
}
