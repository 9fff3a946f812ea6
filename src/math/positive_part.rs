//! The positive semi-definite part of a symmetric 9×9 matrix.

use super::{Mat9, Vec9};

/// C⁺ = Σ max(λ, 0) v vᵀ over the eigenpairs of `c`: of all positive semi-definite matrices the nearest one. Exactly
/// `c` where that is positive definite, which Cholesky tells at a tenth of the cost of the eigenvectors.
pub fn positive_part(c: &Mat9) -> Mat9 {
    if is_positive_definite(c) {
        return *c;
    }
    let (values, vectors) = symmetric_eigen9(c);
    let mut out = *c;
    for (&value, v) in values.iter().zip(&vectors) {
        if value < 0.0 {
            for i in 0..9 {
                for j in 0..9 {
                    out[i][j] -= value * (v[i] * v[j]);
                }
            }
        }
    }
    out
}

/// Whether the Cholesky factorisation of `c` exists.
fn is_positive_definite(c: &Mat9) -> bool {
    let mut l = [[0.0; 9]; 9];
    for j in 0..9 {
        let pivot = c[j][j] - (0..j).map(|k| l[j][k] * l[j][k]).sum::<f64>();
        if pivot.is_nan() || pivot <= 0.0 {
            return false;
        }
        l[j][j] = pivot.sqrt();
        for i in j + 1..9 {
            let rest = c[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            l[i][j] = rest / l[j][j];
        }
    }
    true
}

/// Eigenvalues, in no order, and their eigenvectors. Cyclic Jacobi; Golub and Van Loan, Matrix Computations, §8.5.
fn symmetric_eigen9(c: &Mat9) -> (Vec9, [Vec9; 9]) {
    let mut a = *c;
    let mut vectors: [Vec9; 9] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let size: f64 = a.iter().flatten().map(|x| x * x).sum();
    for _ in 0..30 {
        let off: f64 = (0..9)
            .map(|i| a[i][..i].iter().map(|x| x * x).sum::<f64>())
            .sum();
        if off.is_nan() || off <= 1e-32 * size {
            break;
        }
        for q in 1..9 {
            for p in 0..q {
                rotate(&mut a, &mut vectors, p, q);
            }
        }
    }
    (std::array::from_fn(|i| a[i][i]), vectors)
}

/// The rotation of axes p and q that zeroes a_pq: t² + 2 t θ = 1, θ = (a_qq − a_pp)/(2 a_pq), the smaller root.
fn rotate(a: &mut Mat9, vectors: &mut [Vec9; 9], p: usize, q: usize) {
    let between = a[p][q];
    if between == 0.0 {
        return;
    }
    let gap = a[q][q] - a[p][p];
    let twice = 2.0 * between * gap.signum();
    let t = twice / (gap.abs() + (gap * gap + 4.0 * between * between).sqrt());
    let c = (t * t + 1.0).sqrt().recip();
    let s = t * c;
    for row in a.iter_mut() {
        (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
    }
    for k in 0..9 {
        (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
        (vectors[p][k], vectors[q][k]) = (
            c * vectors[p][k] - s * vectors[q][k],
            s * vectors[p][k] + c * vectors[q][k],
        );
    }
    (a[p][q], a[q][p]) = (0.0, 0.0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Random;

    fn random_symmetric(random: &mut Random, shift: f64) -> Mat9 {
        let mut c = [[0.0; 9]; 9];
        for i in 0..9 {
            for j in 0..=i {
                let x = random.uniform(-1.0, 1.0);
                (c[i][j], c[j][i]) = (x, x);
            }
            c[i][i] += shift;
        }
        c
    }

    #[test]
    fn eigenpairs_are_those_of_the_matrix() {
        let random = &mut Random::new(91);
        for _ in 0..20 {
            let c = random_symmetric(random, 0.0);
            let (values, vectors) = symmetric_eigen9(&c);
            for (value, v) in values.iter().zip(&vectors) {
                for i in 0..9 {
                    let image: f64 = (0..9).map(|j| c[i][j] * v[j]).sum();
                    assert!((image - value * v[i]).abs() < 1e-13);
                }
                let length: f64 = v.iter().map(|x| x * x).sum();
                assert!((length - 1.0).abs() < 1e-13);
            }
        }
    }

    #[test]
    fn the_positive_part_of_a_positive_matrix_is_itself() {
        let random = &mut Random::new(92);
        let c = random_symmetric(random, 10.0);
        assert_eq!(positive_part(&c), c);
        let minus = c.map(|row| row.map(|x| -x));
        let nothing = positive_part(&minus);
        assert!(nothing.iter().flatten().all(|x| x.abs() < 1e-13));
    }
}
