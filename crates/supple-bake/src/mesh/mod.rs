//! Skin and bones → the tet mesh of the soft layer between them.
//!
//! - `sound_skin`: what is wrong with a skin, and what is done about it;
//! - `prism_shell`: layers of prisms under a skin, as deep as `thickness` says;
//! - [`lattice`]: a labelled lattice between a skin and the closed surfaces of its bones, which
//!   `bone_axes` derives where none are given;
//! - [`MeshQuality`] and [`MeshReport`]: what a mesh is worth.

mod bcc;
mod bone_axes;
mod bone_nodes;
mod columns;
mod disjoint_sets;
mod lattice;
mod layer;
mod loose_parts;
mod mesher;
mod pieces;
mod prism_shell;
mod quality;
mod report;
mod samples;
mod scanlines;
mod self_intersections;
mod skin_filter;
mod skin_points;
mod sound_skin;
mod thickness;
mod thin_spots;

pub(crate) use bone_axes::{extent, leading_bones, median};
pub use disjoint_sets::DisjointSets;
pub use lattice::{LatticeSize, lattice};
pub(crate) use layer::{mesh_lattice, mesh_shell};
pub(crate) use loose_parts::{add_laplacian, loose_tets};
pub use mesher::Mesher;
pub use quality::MeshQuality;
pub use report::{Hole, MeshReport, SkinReport};
pub(crate) use scanlines::Grid;
pub(crate) use sound_skin::SoundSkin;
pub use thickness::ShellOptions;
pub(crate) use thickness::neighbours;
pub(crate) use thin_spots::closed;
