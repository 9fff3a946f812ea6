//! What a bake did.

use super::bone_mass::BoneMassReport;
use super::cubature::CubatureReport;
use super::mesh::MeshReport;
use serde::{Deserialize, Serialize};

/// Figures of a bake, for people and for JSON.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BakeReport {
    /// What was baked.
    pub name: String,
    /// The layer's mesh, and the skin it was made from.
    pub mesh: MeshReport,
    /// Nodes of the layer.
    pub nodes: usize,
    /// Nodes that no bone holds.
    pub free_nodes: usize,
    /// Tets of the layer.
    pub tets: usize,
    /// Smallest dihedral angle of the layer's tets, degrees.
    pub smallest_dihedral: f64,
    /// Median over the tets of each one's smallest dihedral angle, degrees.
    pub median_dihedral: f64,
    /// Largest dihedral angle, degrees.
    pub largest_dihedral: f64,
    /// Skin vertices.
    pub skin_vertices: usize,
    /// Handles.
    pub handles: usize,
    /// Largest error of Σ U_h f(X_h) + bones' affine columns = f, over f = 1 and the coordinates in
    /// units of the layer's size, before truncation.
    pub linear_precision: f64,
    /// Tets that hang on the rest by an edge or a corner, where the basis is a constant.
    pub loose_tets: usize,
    /// Relative change of the basis by truncation; 0 where it is off.
    pub truncation_cost: f64,
    /// Handles of a skin vertex that has any: mean and most.
    pub handles_per_vertex: (f64, usize),
    /// Handles of a cubature point: mean and most.
    pub handles_per_point: (f64, usize),
    /// The cubature's weights.
    pub cubature: CubatureReport,
    /// The bones' masses.
    pub bones: BoneMassReport,
    /// Mass of the tissue, kg.
    pub tissue_mass: f64,
    /// Seconds each phase took, in order.
    pub seconds: Vec<(String, f64)>,
}
