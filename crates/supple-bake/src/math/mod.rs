//! Sparse systems and their eigenpairs, nearest points, winding numbers.

mod eigen;
mod nearest;
mod sparse;
mod winding;

pub use eigen::largest_eigenpairs;
pub use nearest::NearestPoint;
pub use sparse::{DenseFactor, SparseFactor, SparseSymmetric};
pub use winding::winding_number;
