//! Small dense algebra: rotations, 3×3 decompositions, 9×9 tangents, compressed rows, sparse
//! systems and their eigenpairs.

mod decomposition;
mod eigen;
mod nearest;
mod parallel;
mod positive_part;
mod random;
mod recycle;
mod rotation;
mod rows;
mod sparse;
mod stopwatch;
mod tensor;
mod winding;

pub use decomposition::{SingularValues, singular_values, symmetric_eigen};
pub use eigen::largest_eigenpairs;
pub use nearest::NearestPoint;
pub use parallel::{RowsMut, Split, Strided, in_pool, par_each, par_join, par_map, par_split};
pub use positive_part::positive_part;
pub use random::Random;
pub use recycle::recycled;
pub use rotation::{rotation_exp, rotation_log, skew};
pub use rows::Rows;
pub use sparse::{DenseFactor, SparseFactor, SparseSymmetric};
pub use stopwatch::Stopwatch;
pub use tensor::{Mat9, Vec9, cofactor, contract, double_dot, flatten, turned, unflatten};
pub use winding::winding_number;
