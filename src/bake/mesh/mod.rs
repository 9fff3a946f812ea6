//! Skin and bones → the tet mesh of the soft layer between them.
//!
//! - [`prism_shell`]: layers of prisms under a skin that has no bone surfaces;
//! - [`lattice`]: a labelled lattice between a skin and the closed surfaces of its bones;
//! - [`MeshQuality`]: what a mesh is worth.

mod bcc;
mod bone_nodes;
mod disjoint_sets;
mod lattice;
mod pieces;
mod prism_shell;
mod quality;
mod report;
mod samples;
mod scanlines;
mod skin_points;

pub(super) use disjoint_sets::DisjointSets;
pub use lattice::{LatticeSize, lattice};
pub use prism_shell::{ShellOptions, local_radius, prism_shell};
pub use quality::MeshQuality;
pub use report::{Hole, MeshReport, SkinReport};
pub(super) use scanlines::Grid;
