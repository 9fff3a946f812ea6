//! Skin and bones → the tet mesh of the soft layer between them.
//!
//! - [`prism_shell`]: layers of prisms under a skin that has no bone surfaces;
//! - [`MeshQuality`]: what a mesh is worth.

mod prism_shell;
mod quality;

pub use prism_shell::{ShellOptions, local_radius, prism_shell};
pub use quality::MeshQuality;
