//! Second derivatives with respect to a 3×3 matrix, as 9×9 matrices over the column-major flattening.

use glam::DMat3;

/// A 3×3 matrix as nine numbers, column by column.
pub type Vec9 = [f64; 9];

/// A linear map between 3×3 matrices: `m[row][column]` over [`flatten`]ed indices.
pub type Mat9 = [[f64; 9]; 9];

/// vec(M), column by column.
pub fn flatten(m: DMat3) -> Vec9 {
    m.to_cols_array()
}

/// The matrix of [`flatten`].
pub fn unflatten(v: &Vec9) -> DMat3 {
    DMat3::from_cols_array(v)
}
