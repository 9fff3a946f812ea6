//! The full space: every node its own handle, every tet a point. What everything reduced is compared with.

mod simulation;
mod spaces;
mod sparse_cholesky;

pub use simulation::full_space_simulation;
pub use spaces::{all_tets, full_space, without_tissue};
pub use sparse_cholesky::SparseCholesky;
