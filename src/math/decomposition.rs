//! Eigen- and singular value decomposition of 3×3 matrices by Jacobi rotations.

use glam::{DMat3, DVec3};

/// Eigenvalues (in no order) and eigenvectors (columns) of a symmetric matrix.
///
/// Cyclic Jacobi; Golub and Van Loan, Matrix Computations, §8.5.
pub fn symmetric_eigen(a: DMat3) -> (DVec3, DMat3) {
    let mut a = a.to_cols_array_2d();
    let mut v = DMat3::IDENTITY.to_cols_array_2d();
    for _ in 0..30 {
        let off = a[0][1].powi(2) + a[0][2].powi(2) + a[1][2].powi(2);
        let on = a[0][0].powi(2) + a[1][1].powi(2) + a[2][2].powi(2);
        if off <= 1e-34 * on || off == 0.0 {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
            let c = 1.0 / t.hypot(1.0);
            let s = t * c;
            for k in 0..3 {
                (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
                (v[p][k], v[q][k]) = (c * v[p][k] - s * v[q][k], s * v[p][k] + c * v[q][k]);
            }
            for k in 0..3 {
                (a[k][p], a[k][q]) = (c * a[k][p] - s * a[k][q], s * a[k][p] + c * a[k][q]);
            }
        }
    }
    (
        DVec3::new(a[0][0], a[1][1], a[2][2]),
        DMat3::from_cols_array_2d(&v),
    )
}

/// F = U diag(σ) Vᵀ with U and V rotations: the smallest σ carries the sign of det F.
#[derive(Clone, Copy, Debug)]
pub struct SingularValues {
    /// Left rotation.
    pub u: DMat3,
    /// σ₀ ≥ σ₁ ≥ |σ₂|.
    pub sigma: DVec3,
    /// Right rotation.
    pub v: DMat3,
}

/// The rotation-variant singular value decomposition of `f`.
pub fn singular_values(f: DMat3) -> SingularValues {
    let (squares, vectors) = symmetric_eigen(f.transpose() * f);
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| squares[j].total_cmp(&squares[i]));
    let v0 = vectors.col(order[0]);
    let v1 = vectors.col(order[1]);
    let v = DMat3::from_cols(v0, v1, v0.cross(v1));
    // Gram–Schmidt on F V, so that U stays a rotation where F is near singular.
    let u0 = (f * v0).try_normalize().unwrap_or(DVec3::X);
    let raw = f * v1;
    let u1 = (raw - u0 * u0.dot(raw))
        .try_normalize()
        .unwrap_or_else(|| u0.any_orthonormal_vector());
    let u = DMat3::from_cols(u0, u1, u0.cross(u1));
    let sigma = DVec3::new(u0.dot(f * v0), u1.dot(raw), u.col(2).dot(f * v.col(2)));
    SingularValues { u, sigma, v }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn matrix(range: f64) -> impl Strategy<Value = DMat3> {
        prop::array::uniform9(-range..range).prop_map(|a| DMat3::from_cols_array(&a))
    }

    fn largest(m: DMat3) -> f64 {
        m.to_cols_array()
            .iter()
            .fold(0.0, |a: f64, b| a.max(b.abs()))
    }

    proptest! {
        #[test]
        fn eigen_reconstructs(m in matrix(3.0)) {
            let s = m + m.transpose();
            let (values, q) = symmetric_eigen(s);
            prop_assert!(largest(q * DMat3::from_diagonal(values) * q.transpose() - s) < 1e-12);
            prop_assert!(largest(q.transpose() * q - DMat3::IDENTITY) < 1e-13);
        }

        #[test]
        fn singular_values_reconstruct(m in matrix(3.0)) {
            let SingularValues { u, sigma, v } = singular_values(m);
            prop_assert!(largest(u * DMat3::from_diagonal(sigma) * v.transpose() - m) < 1e-7);
            prop_assert!((u.determinant() - 1.0).abs() < 1e-12 && (v.determinant() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn singular_and_inverted_matrices_keep_rotations() {
        for f in [
            DMat3::ZERO,
            DMat3::from_diagonal(DVec3::new(1.0, 1.0, -0.5)),
            DMat3::from_diagonal(DVec3::new(2.0, 0.0, 0.0)),
        ] {
            let SingularValues { u, sigma, v } = singular_values(f);
            assert!(largest(u * DMat3::from_diagonal(sigma) * v.transpose() - f) < 1e-12);
            assert!((u.determinant() - 1.0).abs() < 1e-12);
        }
    }
}
