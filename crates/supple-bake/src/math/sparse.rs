//! Sparse symmetric positive definite systems: one factorisation, many right-hand sides.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, Mat, MatMut, Par, Side};
use supple::internal::math::par_each;
use supple::{Error, Result};

/// The lower triangle of a symmetric matrix, column by column, rows rising.
#[derive(Clone, Debug)]
pub struct SparseSymmetric {
    column_starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
}

impl SparseSymmetric {
    /// Sums `entries` (row, column, value) of the lower triangle; entries above it are mirrored
    /// ones and must not be there. Equal places are summed in the order given.
    pub fn from_entries(size: usize, entries: &[(u32, u32, f64)]) -> Self {
        // Two counting sorts, by row and then by column: stable, so the sums keep their order.
        let sorted = counting_sort(size, entries, |e| e.0 as usize);
        let sorted = counting_sort(size, &sorted, |e| e.1 as usize);
        let mut out = Self {
            column_starts: vec![0; size + 1],
            rows: Vec::with_capacity(sorted.len() / 3),
            values: Vec::with_capacity(sorted.len() / 3),
        };
        let mut last = None;
        for &(row, column, value) in &sorted {
            debug_assert!(row >= column);
            if last == Some((row, column)) {
                *out.values.last_mut().expect("an entry was pushed") += value;
            } else {
                out.rows.push(row as usize);
                out.values.push(value);
                out.column_starts[column as usize + 1] += 1;
                last = Some((row, column));
            }
        }
        for column in 0..size {
            out.column_starts[column + 1] += out.column_starts[column];
        }
        out
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.column_starts.len() - 1
    }

    /// The stored (row, column, value), row ≥ column.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        (0..self.size()).flat_map(move |column| {
            (self.column_starts[column]..self.column_starts[column + 1])
                .map(move |k| (self.rows[k], column, self.values[k]))
        })
    }

    /// Mean of the diagonal.
    pub fn mean_diagonal(&self) -> f64 {
        let trace: f64 = self
            .entries()
            .filter(|(row, column, _)| row == column)
            .map(|e| e.2)
            .sum();
        trace / self.size().max(1) as f64
    }

    /// A x.
    pub fn multiply(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for (row, column, value) in self.entries() {
            y[row] += value * x[column];
            if row != column {
                y[column] += value * x[row];
            }
        }
        y
    }

    fn as_faer(&self) -> SparseColMatRef<'_, usize, f64> {
        let n = self.size();
        let symbolic =
            SymbolicSparseColMatRef::new_checked(n, n, &self.column_starts, None, &self.rows);
        SparseColMatRef::new(symbolic, &self.values)
    }
}

fn counting_sort(
    size: usize,
    entries: &[(u32, u32, f64)],
    key: impl Fn(&(u32, u32, f64)) -> usize,
) -> Vec<(u32, u32, f64)> {
    let mut next = vec![0usize; size + 1];
    entries.iter().for_each(|e| next[key(e) + 1] += 1);
    for i in 0..size {
        next[i + 1] += next[i];
    }
    let mut out = vec![(0, 0, 0.0); entries.len()];
    for e in entries {
        let slot = &mut next[key(e)];
        out[*slot] = *e;
        *slot += 1;
    }
    out
}

/// A = L Lᵀ of a sparse matrix (supernodal; faer). One thread, so that the bits do not depend on
/// how many there are.
#[derive(Debug)]
pub struct SparseFactor {
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
}

impl SparseFactor {
    /// Right-hand sides a task takes together.
    const GROUP: usize = 16;

    /// Factors `matrix`; `system` names it in errors.
    pub fn new(matrix: &SparseSymmetric, system: &'static str) -> Result<Self> {
        let fail = |problem: String| Error::Solve { system, problem };
        let a = matrix.as_faer();
        let symbolic = factorize_symbolic_cholesky(
            a.symbolic(),
            Side::Lower,
            SymmetricOrdering::Amd,
            CholeskySymbolicParams {
                // The automatic choice was measured to be 4 times slower on biharmonic systems.
                supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
                ..Default::default()
            },
        )
        .map_err(|e| fail(format!("no ordering found: {e:?}")))?;
        let mut values = vec![0.0; symbolic.len_val()];
        let mut memory = MemBuffer::try_new(
            symbolic.factorize_numeric_llt_scratch::<f64>(Par::Seq, Default::default()),
        )
        .map_err(|_| fail("out of memory".into()))?;
        symbolic
            .factorize_numeric_llt(
                &mut values,
                a,
                Side::Lower,
                Default::default(),
                Par::Seq,
                MemStack::new(&mut memory),
                Default::default(),
            )
            .map_err(|llt::factor::LltError::NonPositivePivot { index }| {
                fail(format!("not positive definite (pivot {index})"))
            })?;
        Ok(Self { symbolic, values })
    }

    /// Non-zeros of L.
    pub fn stored(&self) -> usize {
        self.values.len()
    }

    /// For each `i` in `0..count`: `right_hand_side(i, b)` fills b (zeroed before), A x = b is
    /// solved, and `take(i, x)` makes the result. Split over threads by groups of columns, with
    /// results that do not depend on how many threads there are.
    pub fn solve_each<T: Send>(
        &self,
        count: usize,
        right_hand_side: impl Fn(usize, &mut [f64]) + Sync + Send,
        take: impl Fn(usize, &[f64]) -> T + Sync + Send,
    ) -> Vec<T> {
        self.solve_sets(count, 1, right_hand_side, take)
    }

    /// The same of sets of `size` columns (16 at most), one after the other in b and x.
    pub fn solve_sets<T: Send>(
        &self,
        count: usize,
        size: usize,
        right_hand_side: impl Fn(usize, &mut [f64]) + Sync + Send,
        take: impl Fn(usize, &[f64]) -> T + Sync + Send,
    ) -> Vec<T> {
        let n = self.symbolic.nrows();
        let group = (Self::GROUP / size).max(1);
        let mut groups: Vec<Vec<T>> = (0..count.div_ceil(group)).map(|_| Vec::new()).collect();
        par_each(&mut groups, 1, |g, out| {
            let sets = (g * group)..((g + 1) * group).min(count);
            let width = size * sets.len();
            let mut x = vec![0.0; n * width];
            if n > 0 {
                for (i, b) in sets.clone().zip(x.chunks_exact_mut(n * size)) {
                    right_hand_side(i, b);
                }
                let mut memory =
                    MemBuffer::new(self.symbolic.solve_in_place_scratch::<f64>(width, Par::Seq));
                LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
                    Conj::No,
                    MatMut::from_column_major_slice_mut(&mut x, n, width),
                    Par::Seq,
                    MemStack::new(&mut memory),
                );
            }
            let set = |k: usize| &x[k * size * n..(k + 1) * size * n];
            out.extend(sets.enumerate().map(|(k, i)| take(i, set(k))));
        });
        groups.into_iter().flatten().collect()
    }

    /// Solves A x = b.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        self.solve_each(1, |_, x| x.copy_from_slice(b), |_, x| x.to_vec())
            .pop()
            .unwrap_or_default()
    }
}

/// A = L Lᵀ of a dense matrix, one thread.
#[derive(Debug)]
pub struct DenseFactor {
    factor: Mat<f64>,
}

impl DenseFactor {
    /// Factors the symmetric matrix with these columns (the lower triangle is read); `system`
    /// names it in errors.
    pub fn new(columns: &[Vec<f64>], system: &'static str) -> Result<Self> {
        let n = columns.len();
        let mut factor = Mat::from_fn(n, n, |i, j| columns[j][i]);
        let mut memory = MemBuffer::new(llt::factor::cholesky_in_place_scratch::<f64>(
            n,
            Par::Seq,
            Default::default(),
        ));
        llt::factor::cholesky_in_place(
            factor.as_mut(),
            Default::default(),
            Par::Seq,
            MemStack::new(&mut memory),
            Default::default(),
        )
        .map_err(|llt::factor::LltError::NonPositivePivot { index }| {
            let problem = format!("not positive definite (pivot {index})");
            Error::Solve { system, problem }
        })?;
        Ok(Self { factor })
    }

    /// Solves A x = b.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let mut x = b.to_vec();
        llt::solve::solve_in_place(
            self.factor.as_ref(),
            MatMut::from_column_major_slice_mut(&mut x, b.len(), 1),
            Par::Seq,
            MemStack::new(&mut []),
        );
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tridiagonal (2.5, −1) of size `n`, each off-diagonal entry given in two halves.
    fn tridiagonal(n: u32) -> SparseSymmetric {
        let entries: Vec<_> = (0..n)
            .flat_map(|i| {
                [
                    (i, i, 2.5),
                    ((i + 1).min(n - 1), i, -0.5),
                    ((i + 1).min(n - 1), i, -0.5),
                ]
            })
            .filter(|&(row, column, value)| row != column || value > 0.0)
            .collect();
        SparseSymmetric::from_entries(n as usize, &entries)
    }

    #[test]
    fn many_columns_solve_as_one_does() {
        let a = tridiagonal(50);
        let cholesky = SparseFactor::new(&a, "test").unwrap();
        let x = |i: usize| -> Vec<f64> { (0..50).map(|k| ((k * (i + 3)) as f64).sin()).collect() };
        let solved = cholesky.solve_each(
            37,
            |i, b| b.copy_from_slice(&a.multiply(&x(i))),
            |_, x| x.to_vec(),
        );
        for (i, found) in solved.iter().enumerate() {
            for (f, e) in found.iter().zip(x(i)) {
                approx::assert_relative_eq!(*f, e, epsilon = 1e-13);
            }
        }
    }

    #[test]
    fn dense_agrees_with_sparse() {
        let a = tridiagonal(20);
        let mut columns = vec![vec![0.0; 20]; 20];
        a.entries().for_each(|(i, j, v)| columns[j][i] = v);
        let b: Vec<f64> = (0..20).map(|k| (k as f64).cos()).collect();
        let dense = DenseFactor::new(&columns, "test").unwrap().solve(&b);
        let sparse = SparseFactor::new(&a, "test").unwrap().solve(&b);
        for (d, s) in dense.iter().zip(&sparse) {
            approx::assert_relative_eq!(*d, *s, epsilon = 1e-14);
        }
    }

    #[test]
    fn an_indefinite_matrix_is_a_typed_error() {
        let a = SparseSymmetric::from_entries(2, &[(0, 0, 1.0), (1, 0, 2.0), (1, 1, 1.0)]);
        let error = SparseFactor::new(&a, "the system").unwrap_err().to_string();
        assert!(
            error.contains("the system") && error.contains("positive definite"),
            "{error}"
        );
    }
}
