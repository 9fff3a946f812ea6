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

/// A : B = Σ A_ij B_ij.
pub fn double_dot(a: DMat3, b: DMat3) -> f64 {
    a.x_axis.dot(b.x_axis) + a.y_axis.dot(b.y_axis) + a.z_axis.dot(b.z_axis)
}

/// cof M = ∂ det M/∂M, which is det(M) M⁻ᵀ where that exists.
pub fn cofactor(m: DMat3) -> DMat3 {
    DMat3::from_cols(
        m.y_axis.cross(m.z_axis),
        m.z_axis.cross(m.x_axis),
        m.x_axis.cross(m.y_axis),
    )
}

/// C : D, the matrix with vec(C : D) = C vec(D).
pub fn contract(c: &Mat9, d: DMat3) -> DMat3 {
    let d = flatten(d);
    unflatten(&std::array::from_fn(|i| {
        (0..9).map(|j| c[i][j] * d[j]).sum()
    }))
}

/// (G ⊗ G) C (G ⊗ G)ᵀ: the map that takes G A Gᵀ to G (C : A) Gᵀ.
pub fn turned(c: &Mat9, g: DMat3) -> Mat9 {
    let turn_rows =
        |m: &Mat9| -> Mat9 { m.map(|row| flatten(g * unflatten(&row) * g.transpose())) };
    transposed(&turn_rows(&transposed(&turn_rows(c))))
}

fn transposed(m: &Mat9) -> Mat9 {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}
