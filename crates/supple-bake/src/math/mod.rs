//! Sparse systems and their eigenpairs, searches among points and triangles, winding numbers.

mod blocks;
mod eigen;
mod nearest;
mod sparse;
mod triangles;
mod winding;

pub(crate) use blocks::Blocks;
pub use eigen::largest_eigenpairs;
pub use nearest::NearestPoint;
pub use sparse::{DenseFactor, SparseFactor, SparseSymmetric};
pub(crate) use triangles::{TriangleTree, closest_point};
pub use winding::winding_number;
