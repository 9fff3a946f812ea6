//! Small dense algebra: rotations, 3×3 decompositions, 9×9 tangents, compressed rows.

mod decomposition;
mod parallel;
mod positive_part;
mod random;
mod recycle;
mod rotation;
mod rows;
mod stopwatch;
mod tensor;

pub use decomposition::{SingularValues, singular_values, symmetric_eigen};
pub use parallel::{
    RowsMut, Split, Strided, in_pool, par_each, par_join, par_map, par_members, par_split,
    thread_index, threads,
};
pub use positive_part::positive_part;
pub use random::Random;
pub use recycle::recycled;
pub use rotation::{rotation_exp, rotation_log, skew};
pub use rows::Rows;
pub use stopwatch::Stopwatch;
pub use tensor::{Mat9, Vec9, cofactor, contract, double_dot, flatten, turned, unflatten};
