//! The linear system of a Newton step.

use crate::Result;
use crate::potential::BlockPattern;

/// What a solve had to do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Shift added to the scaled diagonal (which is 1 everywhere), 0 where none was needed.
    pub diagonal_shift: f64,
    /// |g + H δ| / |g| over the free DoFs, with the unshifted H.
    pub residual: f64,
}

/// Solves H δ = −g over the free DoFs.
pub trait LinearSolver {
    /// Solves for `step`, whose `fixed` DoFs come out 0. `hessian` holds the blocks of the pattern
    /// that the solver was made for, lower triangle, each 3×3 column by column; it may end before the rows of the last DoFs, which
    /// are fixed then. A matrix that is not positive
    /// definite gets the first of `shifts`, rising, that makes it so.
    ///
    /// # Errors
    /// None does.
    fn solve_shifted(
        &mut self,
        hessian: &[[f64; 9]],
        gradient: &[f64],
        fixed: &[bool],
        step: &mut [f64],
        shifts: &[f64],
    ) -> Result<SolveReport>;

    /// [`LinearSolver::solve_shifted`] by 0 to 1 on the scaled diagonal, which is 1 everywhere.
    ///
    /// # Errors
    /// The matrix is far from positive definite.
    fn solve(
        &mut self,
        hessian: &[[f64; 9]],
        gradient: &[f64],
        fixed: &[bool],
        step: &mut [f64],
    ) -> Result<SolveReport> {
        self.solve_shifted(hessian, gradient, fixed, step, &DIAGONAL_SHIFTS)
    }
}

/// `out = H x + y` with the packed lower triangle. Rows that `hessian` ends before are of DoFs that are fixed.
pub fn multiply_add(
    pattern: &BlockPattern,
    hessian: &[[f64; 9]],
    x: &[f64],
    y: &[f64],
    out: &mut [f64],
) {
    out.copy_from_slice(y);
    let columns = pattern.columns();
    let three = |values: &[f64], block: usize| [0, 1, 2].map(|i| values[3 * block + i]);
    for row in 0..columns.len() {
        let range = columns.range(row);
        if range.end > hessian.len() {
            break;
        }
        let (x_row, mut sum) = (three(x, row), three(out, row));
        for (&column, block) in columns.row(row).iter().zip(&hessian[range]) {
            let (column, x_column) = (column as usize, three(x, column as usize));
            for j in 0..3 {
                for i in 0..3 {
                    sum[i] += block[3 * j + i] * x_column[j];
                }
            }
            if row != column {
                let out = &mut out[3 * column..3 * column + 3];
                for j in 0..3 {
                    for i in 0..3 {
                        out[j] += block[3 * j + i] * x_row[i];
                    }
                }
            }
        }
        out[3 * row..3 * row + 3].copy_from_slice(&sum);
    }
}

/// The scaling d with d_i² H_ii = 1, which brings springs of 1e6 N/m and handles of a few N/m to one
/// size. Fixed DoFs, and diagonals that are not positive (the factorisation will say so), keep 1.
pub fn diagonal_scaling(
    pattern: &BlockPattern,
    hessian: &[[f64; 9]],
    fixed: &[bool],
    scaling: &mut [f64],
) {
    let columns = pattern.columns();
    for row in 0..columns.len() {
        // The diagonal block is the last of its row.
        let block = hessian.get(columns.range(row).end - 1);
        for axis in 0..3 {
            let (dof, diagonal) = (3 * row + axis, block.map_or(0.0, |b| b[4 * axis]));
            scaling[dof] = if !fixed[dof] && diagonal > 0.0 {
                diagonal.sqrt().recip()
            } else {
                1.0
            };
        }
    }
}

/// Shifts of the scaled diagonal (1) that are tried in turn when a matrix is not positive definite.
pub(super) const DIAGONAL_SHIFTS: [f64; 7] = [0.0, 1e-8, 1e-6, 1e-4, 1e-2, 0.1, 1.0];

/// |D r| over the free DoFs.
pub fn scaled_norm(r: &[f64], scaling: &[f64], fixed: &[bool]) -> f64 {
    let squares = r.iter().zip(scaling).zip(fixed);
    squares
        .map(|((r, d), fixed)| if *fixed { 0.0 } else { (r * d).powi(2) })
        .sum::<f64>()
        .sqrt()
}
