//! A few eigenpairs of a large symmetric operator.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::prelude::{Reborrow, ReborrowMut};
use faer::{Accum, Mat, MatRef, Par};
use supple::internal::math::Random;
use supple::{Error, Result};

/// Columns that the operator is applied to together. Eigenvalues of a higher multiplicity than this would be missed;
/// a single vector misses all that are not simple, as those of anything symmetric are not.
const BLOCK: usize = 16;
/// Restarts before it is said not to converge.
const MOST_RESTARTS: usize = 60;

/// The `count` largest eigenvalues of a symmetric positive semi-definite operator on vectors of length `size`, falling,
/// each with its eigenvector of length 1: block Lanczos with full orthogonalisation and thick restarts (Wu and Simon
/// 2000). `apply(x, y)` writes A x to y, both a few columns one after the other. Each residual |A y − θ y| is at most
/// `tolerance` times the largest eigenvalue. `system` names the operator in errors. The bits do not depend on the
/// number of threads if those of `apply` do not.
///
/// # Errors
/// [`Error::Invalid`] where more than a third of `size` pairs are asked for; [`Error::Solve`] where they do not
/// converge.
pub fn largest_eigenpairs(
    size: usize,
    count: usize,
    tolerance: f64,
    system: &'static str,
    apply: &dyn Fn(&[f64], &mut [f64]),
) -> Result<Vec<(f64, Vec<f64>)>> {
    if count == 0 || 3 * count > size {
        let problem =
            format!("{count} eigenpairs of {size} unknowns: ask for 1 to a third of them");
        return Err(Error::invalid("count", problem));
    }
    let block = BLOCK.min((size - count) / 4).max(1);
    let room = (2 * count + 4 * block).min(size - block);
    let mut krylov = Krylov::new(size, block, room);
    for _ in 0..MOST_RESTARTS {
        while krylov.taken + block <= room {
            krylov.extend(apply);
        }
        let ritz = krylov.ritz(system)?;
        let largest = ritz.values[0];
        if !(largest > 0.0 && largest.is_finite()) {
            let problem = format!("its largest eigenvalue is {largest}");
            return Err(Error::Solve { system, problem });
        }
        let wanted = &ritz.residuals[..count];
        if wanted.iter().all(|r| *r <= tolerance * largest) {
            let vectors = krylov.combine(ritz.vectors.subcols(0, count));
            let pair = |i: usize| (ritz.values[i], vectors.col(i).iter().copied().collect());
            return Ok((0..count).map(pair).collect());
        }
        // What is not wanted yet converges next, so half of the rest stays.
        krylov.restart(&ritz, (count + krylov.taken - block) / 2);
    }
    let problem = format!("{count} eigenpairs did not converge in {MOST_RESTARTS} restarts");
    Err(Error::Solve { system, problem })
}

/// An orthonormal basis V with H = Vᵀ A V, and the block that comes next: A V = V H + X R Eᵀ, E the last block's
/// columns of the identity.
struct Krylov {
    /// V, then X, then room.
    basis: Mat<f64>,
    projected: Mat<f64>,
    /// R.
    last: Mat<f64>,
    /// Columns of V.
    taken: usize,
    block: usize,
    random: Random,
}

/// Eigenpairs of H, falling.
struct Ritz {
    values: Vec<f64>,
    /// Columns over V.
    vectors: Mat<f64>,
    /// |A y − θ y|.
    residuals: Vec<f64>,
}

impl Krylov {
    fn new(size: usize, block: usize, room: usize) -> Self {
        let mut krylov = Self {
            basis: Mat::zeros(size, room + block),
            projected: Mat::zeros(room, room),
            last: Mat::zeros(block, block),
            taken: 0,
            block,
            random: Random::new(1),
        };
        let start = krylov.random_columns(block);
        krylov.basis.subcols_mut(0, block).copy_from(start);
        krylov.orthonormalise_next();
        krylov
    }

    fn random_columns(&mut self, count: usize) -> Mat<f64> {
        let random = &mut self.random;
        Mat::from_fn(self.basis.nrows(), count, |_, _| random.uniform(-1.0, 1.0))
    }

    /// Takes X into V, and makes the next X of A X.
    fn extend(&mut self, apply: &dyn Fn(&[f64], &mut [f64])) {
        let (size, block) = (self.basis.nrows(), self.block);
        let (from, to) = (self.taken, self.taken + block);
        let mut image = Mat::<f64>::zeros(size, block);
        let mut columns = vec![0.0; 2 * size * block];
        let (x, y) = columns.split_at_mut(size * block);
        for (j, x) in x.chunks_exact_mut(size).enumerate() {
            x.iter_mut()
                .zip(self.basis.col(from + j).iter())
                .for_each(|(x, v)| *x = *v);
        }
        apply(x, y);
        for (j, y) in y.chunks_exact(size).enumerate() {
            image
                .col_mut(j)
                .iter_mut()
                .zip(y)
                .for_each(|(w, y)| *w = *y);
        }
        // Twice is enough (Kahan and Parlett).
        let mut shares = Mat::<f64>::zeros(to, block);
        for _ in 0..2 {
            shares += project_out(self.basis.subcols(0, to), &mut image);
        }
        for j in 0..block {
            for i in 0..to {
                // H is symmetric; its last block is so up to rounding.
                self.projected[(i, from + j)] = shares[(i, j)];
                self.projected[(from + j, i)] = shares[(i, j)];
            }
        }
        self.taken = to;
        self.basis.subcols_mut(to, block).copy_from(image);
        self.orthonormalise_next();
    }

    /// X R = X by Gram and Schmidt; a column that the others and V span is replaced by a random one.
    fn orthonormalise_next(&mut self) {
        let (first, block) = (self.taken, self.block);
        self.last.fill(0.0);
        for j in 0..block {
            let before = self.basis.col(first + j).norm_l2();
            let mut length = self.reduce(first, j, true);
            // Nothing but rounding is left.
            if length <= 1e-13 * before || before == 0.0 {
                self.last[(j, j)] = 0.0;
                let fresh = self.random_columns(1);
                self.basis.col_mut(first + j).copy_from(fresh.col(0));
                let mut column = Mat::from_fn(fresh.nrows(), 1, |i, _| fresh[(i, 0)]);
                for _ in 0..2 {
                    project_out(self.basis.subcols(0, first), &mut column);
                }
                self.basis.col_mut(first + j).copy_from(column.col(0));
                length = self.reduce(first, j, false);
            } else {
                self.last[(j, j)] = length;
            }
            self.basis
                .col_mut(first + j)
                .iter_mut()
                .for_each(|x| *x /= length);
        }
    }

    /// Takes the block's earlier columns out of its column `j`, twice, and gives its length then.
    fn reduce(&mut self, first: usize, j: usize, keep_shares: bool) -> f64 {
        let (done, mut rest) = self.basis.as_mut().split_at_col_mut(first + j);
        let mut column = rest.rb_mut().col_mut(0);
        for _ in 0..2 {
            for i in 0..j {
                let other = done.rb().col(first + i);
                let share: f64 = other
                    .iter()
                    .zip(column.rb().iter())
                    .map(|(a, b)| a * b)
                    .sum();
                column
                    .rb_mut()
                    .iter_mut()
                    .zip(other.iter())
                    .for_each(|(c, o)| *c -= share * o);
                if keep_shares {
                    self.last[(i, j)] += share;
                }
            }
        }
        column.norm_l2()
    }

    fn ritz(&self, system: &'static str) -> Result<Ritz> {
        let (taken, block) = (self.taken, self.block);
        let projected = self.projected.submatrix(0, 0, taken, taken);
        let mut memory = MemBuffer::new(self_adjoint_evd_scratch::<f64>(
            taken,
            ComputeEigenvectors::Yes,
            Par::Seq,
            Default::default(),
        ));
        let mut values = faer::diag::Diag::<f64>::zeros(taken);
        let mut rising = Mat::<f64>::zeros(taken, taken);
        self_adjoint_evd(
            projected,
            values.as_mut(),
            Some(rising.as_mut()),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        )
        .map_err(|_| Error::Solve {
            system,
            problem: "the projected eigenproblem did not converge".into(),
        })?;
        let vectors = Mat::from_fn(taken, taken, |i, j| rising[(i, taken - 1 - j)]);
        let values = values.column_vector();
        let values: Vec<f64> = (0..taken).rev().map(|i| values[i]).collect();
        let mut rest = Mat::<f64>::zeros(block, taken);
        let bottom = vectors.subrows(taken - block, block);
        matmul(
            rest.as_mut(),
            Accum::Replace,
            self.last.as_ref(),
            bottom,
            1.0,
            Par::Seq,
        );
        let residuals = (0..taken).map(|i| rest.col(i).norm_l2()).collect();
        Ok(Ritz {
            values,
            vectors,
            residuals,
        })
    }

    /// V Q.
    fn combine(&self, q: MatRef<'_, f64>) -> Mat<f64> {
        let mut out = Mat::zeros(self.basis.nrows(), q.ncols());
        let v = self.basis.subcols(0, self.taken);
        matmul(out.as_mut(), Accum::Replace, v, q, 1.0, Par::Seq);
        out
    }

    /// Keeps the first `kept` Ritz vectors as V, and X: A V = V Θ + X R (the last rows of Q) still has its form,
    /// as the next X takes its shares of all of V.
    fn restart(&mut self, ritz: &Ritz, kept: usize) {
        let vectors = self.combine(ritz.vectors.subcols(0, kept));
        let next = self.basis.subcols(self.taken, self.block).to_owned();
        self.basis.subcols_mut(0, kept).copy_from(vectors);
        self.basis.subcols_mut(kept, self.block).copy_from(next);
        self.projected.fill(0.0);
        (0..kept).for_each(|i| self.projected[(i, i)] = ritz.values[i]);
        self.taken = kept;
    }
}

/// W −= V Vᵀ W, and Vᵀ W.
fn project_out(v: MatRef<'_, f64>, w: &mut Mat<f64>) -> Mat<f64> {
    let mut shares = Mat::<f64>::zeros(v.ncols(), w.ncols());
    matmul(
        shares.as_mut(),
        Accum::Replace,
        v.transpose(),
        w.as_ref(),
        1.0,
        Par::Seq,
    );
    matmul(w.as_mut(), Accum::Add, v, shares.as_ref(), -1.0, Par::Seq);
    shares
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The inverse of tridiagonal (−1, 2, −1), a string's static response, by Thomas' algorithm.
    fn string(x: &[f64], y: &mut [f64]) {
        let n = x.len();
        let mut above = vec![0.0; n];
        for i in 0..n {
            let (before, carried) = match i {
                0 => (0.0, 0.0),
                _ => (above[i - 1], y[i - 1]),
            };
            above[i] = 1.0 / (2.0 - before);
            y[i] = (x[i] + carried) * above[i];
        }
        for i in (0..n - 1).rev() {
            y[i] += above[i] * y[i + 1];
        }
    }

    /// θ of the string's mode `k`, from 1: 1/θ = 4 sin²(kπ/(2n + 2)).
    fn expected(k: usize, n: usize) -> f64 {
        let angle = k as f64 * std::f64::consts::PI / (n + 1) as f64;
        0.25 / (0.5 * angle).sin().powi(2)
    }

    #[test]
    fn pairs_of_a_string_are_its_sines() {
        for (n, count) in [(30, 2), (200, 30), (600, 90)] {
            let apply = |x: &[f64], y: &mut [f64]| {
                let columns = x.chunks_exact(n).zip(y.chunks_exact_mut(n));
                columns.for_each(|(x, y)| string(x, y));
            };
            let pairs = largest_eigenpairs(n, count, 1e-12, "string", &apply).unwrap();
            for (k, (theta, y)) in pairs.iter().enumerate() {
                let off = (theta - expected(k + 1, n)).abs();
                assert!(off < 1e-11 * expected(1, n), "{k} of {n}: {off:e}");
                let angle = (k + 1) as f64 * std::f64::consts::PI / (n + 1) as f64;
                let overlap: f64 = (0..n).map(|i| (angle * (i + 1) as f64).sin() * y[i]).sum();
                let length = ((n + 1) as f64 / 2.0).sqrt();
                assert!(
                    (overlap.abs() / length - 1.0).abs() < 1e-6,
                    "mode {k} of {n}"
                );
            }
        }
    }

    #[test]
    fn no_copy_of_a_multiple_eigenvalue_is_missed() {
        // Three strings side by side: every eigenvalue three times.
        const N: usize = 100;
        let apply = |x: &[f64], y: &mut [f64]| {
            let columns = x.chunks_exact(N).zip(y.chunks_exact_mut(N));
            columns.for_each(|(x, y)| string(x, y));
        };
        let pairs = largest_eigenpairs(3 * N, 30, 1e-12, "strings", &apply).unwrap();
        for (k, (theta, y)) in pairs.iter().enumerate() {
            let off = (theta - expected(k / 3 + 1, N)).abs();
            assert!(off < 1e-11 * expected(1, N), "{k}: {off:e}");
            for (_, other) in &pairs[..k] {
                let product: f64 = y.iter().zip(other).map(|(a, b)| a * b).sum();
                assert!(product.abs() < 1e-12, "{k}: {product:e}");
            }
        }
    }

    #[test]
    fn an_operator_of_low_rank_is_told_all_of() {
        // diag(3, 2, 1, 0, …): the Krylov space is soon exhausted.
        let apply = |x: &[f64], y: &mut [f64]| {
            y.fill(0.0);
            for (x, y) in x.chunks_exact(60).zip(y.chunks_exact_mut(60)) {
                (0..3).for_each(|i| y[i] = (3 - i) as f64 * x[i]);
            }
        };
        let pairs = largest_eigenpairs(60, 5, 1e-12, "low rank", &apply).unwrap();
        for ((theta, _), expected) in pairs.iter().zip([3.0, 2.0, 1.0, 0.0, 0.0]) {
            assert!((theta - expected).abs() < 1e-12, "{theta}");
        }
    }

    #[test]
    fn what_cannot_be_found_is_a_typed_error() {
        let nothing = |_: &[f64], y: &mut [f64]| y.fill(0.0);
        let error = largest_eigenpairs(30, 2, 1e-9, "nothing", &nothing).unwrap_err();
        assert!(error.to_string().contains("nothing"), "{error}");
        assert!(largest_eigenpairs(30, 11, 1e-9, "too many", &nothing).is_err());
    }
}
