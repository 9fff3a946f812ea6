//! A few eigenpairs of a large symmetric operator.

use super::Random;
use crate::{Error, Result};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::matrix_free::LinOp;
use faer::matrix_free::eigen::{
    PartialEigenParams, partial_self_adjoint_eigen, partial_self_adjoint_eigen_scratch,
};
use faer::{Col, Mat, MatMut, MatRef, Par};

/// Restarts before Lanczos is said not to converge.
const MOST_RESTARTS: usize = 100;
/// Power iterations that find the operator's size.
const POWER_ITERATIONS: usize = 8;

/// The `count` largest eigenvalues of a symmetric positive semi-definite operator on vectors of length `size`, falling,
/// each with its eigenvector of length 1, by restarted Lanczos with full orthogonalisation (faer). `apply(x, out)`
/// writes A x. Each residual |A y − θ y| is at most `tolerance` times the largest eigenvalue. `system` names the
/// operator in errors. One thread, so that the bits do not depend on how many there are.
///
/// # Errors
/// [`Error::Invalid`] where more than a third of `size` pairs are asked for; [`Error::Solve`] where they do not
/// converge.
pub fn largest_eigenpairs(
    size: usize,
    count: usize,
    tolerance: f64,
    system: &'static str,
    apply: &(dyn Fn(&[f64], &mut [f64]) + Sync),
) -> Result<Vec<(f64, Vec<f64>)>> {
    if count == 0 || 3 * count > size {
        let problem =
            format!("{count} eigenpairs of {size} unknowns: ask for 1 to a third of them");
        return Err(Error::invalid("count", problem));
    }
    let mut random = Random::new(1);
    let mut start = vec![0.0; size];
    start
        .iter_mut()
        .for_each(|x| *x = random.uniform(-1.0, 1.0));
    let scale = largest_eigenvalue(start.clone(), apply);
    if !(scale > 0.0 && scale.is_finite()) {
        let problem = format!("its largest eigenvalue is {scale}");
        return Err(Error::Solve { system, problem });
    }
    let operator = Operator { size, scale, apply };
    let parameters = PartialEigenParams {
        // Room for the Krylov space: twice what is wanted, and enough for the few-pairs case.
        max_dim: (2 * count).max(40).min(size - 1),
        max_restarts: MOST_RESTARTS,
        ..Default::default()
    };
    let request = partial_self_adjoint_eigen_scratch(&operator, count, Par::Seq, parameters);
    let mut memory = MemBuffer::try_new(request).map_err(|_| Error::Solve {
        system,
        problem: "out of memory".into(),
    })?;
    let mut vectors = Mat::<f64>::zeros(size, count);
    let mut values = vec![0.0; count];
    let found = partial_self_adjoint_eigen(
        vectors.as_mut(),
        &mut values,
        &operator,
        Col::from_iter(start).as_ref(),
        tolerance,
        Par::Seq,
        MemStack::new(&mut memory),
        parameters,
    );
    if found.n_converged_eigen < count {
        let problem = format!("{} of {count} modes converged", found.n_converged_eigen);
        return Err(Error::Solve { system, problem });
    }
    let pair =
        |(i, theta): (usize, &f64)| (theta * scale, vectors.col(i).iter().copied().collect());
    Ok(values.iter().enumerate().map(pair).collect())
}

/// About the largest eigenvalue: never more.
fn largest_eigenvalue(mut x: Vec<f64>, apply: &dyn Fn(&[f64], &mut [f64])) -> f64 {
    let norm = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let (mut product, mut value) = (vec![0.0; x.len()], 0.0);
    for _ in 0..POWER_ITERATIONS {
        let length = norm(&x);
        x.iter_mut().for_each(|x| *x /= length);
        apply(&x, &mut product);
        value = norm(&product);
        x.copy_from_slice(&product);
    }
    value
}

/// A/scale, for faer.
struct Operator<'a> {
    size: usize,
    scale: f64,
    apply: &'a (dyn Fn(&[f64], &mut [f64]) + Sync),
}

impl std::fmt::Debug for Operator<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "operator of size {}", self.size)
    }
}

impl LinOp<f64> for Operator<'_> {
    fn apply_scratch(&self, _: usize, _: Par) -> StackReq {
        StackReq::EMPTY
    }

    fn nrows(&self) -> usize {
        self.size
    }

    fn ncols(&self) -> usize {
        self.size
    }

    fn apply(&self, mut out: MatMut<'_, f64>, x: MatRef<'_, f64>, _: Par, _: &mut MemStack) {
        let (mut from, mut to) = (vec![0.0; self.size], vec![0.0; self.size]);
        for j in 0..x.ncols() {
            for (i, f) in from.iter_mut().enumerate() {
                *f = x[(i, j)];
            }
            (self.apply)(&from, &mut to);
            for (i, t) in to.iter().enumerate() {
                out[(i, j)] = t / self.scale;
            }
        }
    }

    fn conj_apply(&self, out: MatMut<'_, f64>, x: MatRef<'_, f64>, par: Par, stack: &mut MemStack) {
        self.apply(out, x, par, stack);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_of_a_string_are_its_sines() {
        // The inverse of tridiagonal (−1, 2, −1): a string's static response, 1/θ = 2 − 2 cos(kπ/(n + 1)).
        const N: usize = 200;
        let apply = |x: &[f64], out: &mut [f64]| {
            // Thomas' algorithm.
            let mut above = vec![0.0; N];
            for i in 0..N {
                let (before, carried) = match i {
                    0 => (0.0, 0.0),
                    _ => (above[i - 1], out[i - 1]),
                };
                let pivot = 2.0 - before;
                above[i] = 1.0 / pivot;
                out[i] = (x[i] + carried) / pivot;
            }
            for i in (0..N - 1).rev() {
                out[i] += above[i] * out[i + 1];
            }
        };
        let pairs = largest_eigenpairs(N, 30, 1e-12, "string", &apply).unwrap();
        for (k, (theta, y)) in pairs.iter().enumerate() {
            let angle = (k + 1) as f64 * std::f64::consts::PI / (N + 1) as f64;
            let expected = 1.0 / (2.0 - 2.0 * angle.cos());
            approx::assert_relative_eq!(*theta, expected, max_relative = 1e-9);
            let sine = |i: usize| (angle * (i + 1) as f64).sin();
            let overlap: f64 = (0..N).map(|i| sine(i) * y[i]).sum();
            let length = ((N + 1) as f64 / 2.0).sqrt();
            assert!((overlap.abs() / length - 1.0).abs() < 1e-9, "mode {k}");
        }
    }

    #[test]
    fn what_cannot_be_found_is_a_typed_error() {
        let nothing = |_: &[f64], out: &mut [f64]| out.fill(0.0);
        let error = largest_eigenpairs(30, 2, 1e-9, "nothing", &nothing).unwrap_err();
        assert!(error.to_string().contains("nothing"), "{error}");
        assert!(largest_eigenpairs(30, 11, 1e-9, "too many", &nothing).is_err());
    }
}
