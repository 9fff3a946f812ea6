//! Eigen- and singular value decomposition of 3×3 matrices by Jacobi rotations.

use glam::{DMat3, DVec3};

/// Eigenvalues (in no order) and eigenvectors (columns) of a symmetric matrix.
///
/// Cyclic Jacobi; Golub and Van Loan, Matrix Computations, §8.5.
pub fn symmetric_eigen(a: DMat3) -> (DVec3, DMat3) {
    let mut diagonal = [a.x_axis.x, a.y_axis.y, a.z_axis.z];
    // Entry k is the one that neither row nor column k holds.
    let mut off = [a.y_axis.z, a.x_axis.z, a.x_axis.y];
    let mut vectors = [DVec3::X, DVec3::Y, DVec3::Z];
    for _ in 0..30 {
        let size = |v: &[f64; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        if size(&off) <= 1e-33 * size(&diagonal) {
            break;
        }
        for (p, q, r) in [(0, 1, 2), (0, 2, 1), (1, 2, 0)] {
            let between = off[r];
            if between == 0.0 {
                continue;
            }
            // The smaller root t of t² + 2θt = 1, θ = (a_qq − a_pp)/(2 a_pq): the tangent of the angle.
            let gap = diagonal[q] - diagonal[p];
            let twice = 2.0 * between * gap.signum();
            let t = twice / (gap.abs() + (gap * gap + 4.0 * between * between).sqrt());
            let c = (t * t + 1.0).sqrt().recip();
            let s = t * c;
            diagonal[p] -= t * between;
            diagonal[q] += t * between;
            off[r] = 0.0;
            // a_rp is off[q], a_rq is off[p].
            (off[q], off[p]) = (c * off[q] - s * off[p], s * off[q] + c * off[p]);
            (vectors[p], vectors[q]) = (
                vectors[p] * c - vectors[q] * s,
                vectors[p] * s + vectors[q] * c,
            );
        }
    }
    let [x, y, z] = vectors;
    (DVec3::from_array(diagonal), DMat3::from_cols(x, y, z))
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
