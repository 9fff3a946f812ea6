//! The full-space system: large and sparse.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor::LltError;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use faer::{Conj, MatMut, Par, Side, Spec};
use supple::internal::linear_solver::{SolveReport, diagonal_scaling, multiply_add, scaled_norm};
use supple::potential::BlockPattern;
use supple::sim::LinearSolver;
use supple::{Error, Result};

/// Supernodal LLᵀ in f64 of the matrix scaled to a unit diagonal, ordered by approximate minimum
/// degree, with the symbolic factorisation done once. An indefinite matrix gets the smallest of the
/// shifts 1e-8 to 1 of the scaled diagonal that factors.
pub struct SparseCholesky {
    pattern: BlockPattern,
    /// The lower triangle by columns.
    structure: SymbolicSparseColMat<usize>,
    symbolic: SymbolicCholesky<usize>,
    /// Where each scalar of each packed block goes in `values`; the upper halves of diagonal blocks
    /// go nowhere.
    slots: Vec<[Option<usize>; 9]>,
    values: Vec<f64>,
    factor: Vec<f64>,
    scratch: MemBuffer,
    scaling: Vec<f64>,
    residual: Vec<f64>,
    parallelism: Par,
}

impl SparseCholesky {
    /// Orders and factors the structure of `pattern`.
    ///
    /// # Errors
    /// Not enough memory.
    pub fn new(pattern: &BlockPattern) -> Result<Self> {
        let failed = |problem: String| Error::Solve {
            system: "full-space Newton system",
            problem,
        };
        let (structure, slots) = lower_triangle(pattern);
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let symbolic = factorize_symbolic_cholesky(
            structure.as_ref(),
            Side::Lower,
            SymmetricOrdering::Amd,
            parameters,
        )
        .map_err(|e| failed(format!("symbolic factorisation: {e:?}")))?;
        let parallelism = parallelism();
        let request = symbolic
            .factorize_numeric_llt_scratch::<f64>(parallelism, Spec::default())
            .or(symbolic.solve_in_place_scratch::<f64>(1, parallelism));
        let dofs = pattern.space().dofs();
        Ok(Self {
            pattern: pattern.clone(),
            values: vec![0.0; structure.compute_nnz()],
            factor: vec![0.0; symbolic.len_val()],
            scratch: MemBuffer::try_new(request)
                .map_err(|_| failed("not enough memory for the factor's scratch".into()))?,
            structure,
            symbolic,
            slots,
            scaling: vec![1.0; dofs],
            residual: vec![0.0; dofs],
            parallelism,
        })
    }

    /// Scalars in the factor L.
    pub fn factor_size(&self) -> usize {
        self.factor.len()
    }

    /// D H D + shift I over free DoFs, I over fixed ones.
    fn fill(&mut self, hessian: &[[f64; 9]], fixed: &[bool], shift: f64) {
        let blocks = self.pattern.blocks();
        for ((block, slots), (row, column)) in hessian.iter().zip(&self.slots).zip(blocks) {
            for (k, slot) in slots.iter().enumerate() {
                let Some(slot) = *slot else { continue };
                let (r, c) = (3 * row + k % 3, 3 * column + k / 3);
                self.values[slot] = if fixed[r] || fixed[c] {
                    f64::from(r == c)
                } else {
                    let diagonal = if r == c { shift } else { 0.0 };
                    self.scaling[r] * block[k] * self.scaling[c] + diagonal
                };
            }
        }
    }

    /// δ = −D (D H D + shift I)⁻¹ D g; the failing pivot otherwise.
    fn factorise_and_solve(
        &mut self,
        gradient: &[f64],
        fixed: &[bool],
        step: &mut [f64],
    ) -> std::result::Result<(), usize> {
        let stack = MemStack::new(&mut self.scratch);
        let factor = self
            .symbolic
            .factorize_numeric_llt(
                &mut self.factor,
                SparseColMatRef::new(self.structure.as_ref(), &self.values),
                Side::Lower,
                Default::default(),
                self.parallelism,
                stack,
                Spec::default(),
            )
            .map_err(|LltError::NonPositivePivot { index }| index)?;
        for (dof, s) in step.iter_mut().enumerate() {
            *s = if fixed[dof] {
                0.0
            } else {
                -self.scaling[dof] * gradient[dof]
            };
        }
        let dofs = step.len();
        factor.solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(step, dofs, 1),
            self.parallelism,
            stack,
        );
        for (s, d) in step.iter_mut().zip(&self.scaling) {
            *s *= d;
        }
        match step.iter().position(|s| !s.is_finite()) {
            Some(index) => Err(index),
            None => Ok(()),
        }
    }
}

impl LinearSolver for SparseCholesky {
    fn solve_shifted(
        &mut self,
        hessian: &[[f64; 9]],
        gradient: &[f64],
        fixed: &[bool],
        step: &mut [f64],
        shifts: &[f64],
    ) -> Result<SolveReport> {
        diagonal_scaling(&self.pattern, hessian, fixed, &mut self.scaling);
        let size = scaled_norm(gradient, &self.scaling, fixed);
        if size == 0.0 {
            step.fill(0.0);
            return Ok(SolveReport::default());
        }
        let mut pivot = 0;
        for &diagonal_shift in shifts {
            self.fill(hessian, fixed, diagonal_shift);
            match self.factorise_and_solve(gradient, fixed, step) {
                Err(index) => pivot = index,
                Ok(()) => {
                    multiply_add(&self.pattern, hessian, step, gradient, &mut self.residual);
                    let residual = scaled_norm(&self.residual, &self.scaling, fixed) / size;
                    return Ok(SolveReport {
                        diagonal_shift,
                        residual,
                    });
                }
            }
        }
        Err(Error::Solve {
            system: "full-space Newton system",
            problem: format!(
                "not positive definite (pivot {pivot}), even with {} added to its scaled diagonal",
                shifts.last().unwrap_or(&0.0)
            ),
        })
    }
}

/// Threads for the factorisation, where there are any.
fn parallelism() -> Par {
    #[cfg(feature = "threads")]
    return Par::rayon(0);
    #[cfg(not(feature = "threads"))]
    Par::Seq
}

/// The scalar structure of the packed blocks by columns, and where each block's scalars go in it.
fn lower_triangle(
    pattern: &BlockPattern,
) -> (SymbolicSparseColMat<usize>, Vec<[Option<usize>; 9]>) {
    // Blocks come row after row; counting them by column keeps the rows of a column rising.
    let blocks = pattern.space().blocks();
    let mut rows_of_column = vec![Vec::new(); blocks];
    for (index, (row, column)) in pattern.blocks().enumerate() {
        rows_of_column[column].push((row, index));
    }
    let mut slots = vec![[None; 9]; pattern.len()];
    let (mut column_starts, mut row_indices) = (vec![0], Vec::new());
    for (column, rows) in rows_of_column.iter().enumerate() {
        for j in 0..3 {
            for &(row, index) in rows {
                for i in 0..3 {
                    if 3 * row + i >= 3 * column + j {
                        slots[index][3 * j + i] = Some(row_indices.len());
                        row_indices.push(3 * row + i);
                    }
                }
            }
            column_starts.push(row_indices.len());
        }
    }
    let dofs = 3 * blocks;
    let structure = SymbolicSparseColMat::new_checked(dofs, dofs, column_starts, None, row_indices);
    (structure, slots)
}
