//! The reduced system: small and nearly dense.

use super::linear_solver::{
    LinearSolver, SolveReport, diagonal_scaling, multiply_add, scaled_norm,
};
use crate::potential::BlockPattern;
use crate::{Error, Result};
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::{factor, solve};
use faer::{Mat, Par, Spec};

/// Relative residual after the refinement above which f32 has not served: with a scaled condition
/// number κ it is (κ ε₃₂)², so this is κ ≈ 10⁵.
pub(super) const SINGLE_PRECISION_RESIDUAL: f64 = 1e-4;

/// LLᵀ of the matrix scaled to a unit diagonal, in f32 with one refinement against the f64 residual
/// (Higham 2002, §12). Where that fails, in f64; where the matrix is indefinite, in f64 with the
/// smallest of the shifts 1e-8 to 1 of the scaled diagonal that factors, which still
/// gives a descent direction. One thread: threads made it slower at these sizes.
///
/// Only free DoFs are in the matrix, in their order; blocks in rows or columns of fixed ones are not read by it.
pub struct DenseCholesky {
    pattern: BlockPattern,
    free: FreeDofs,
    scaling: Vec<f64>,
    residual: Vec<f64>,
    correction: Vec<f64>,
    single: Factor<f32>,
    /// Made at the first failure in f32.
    double: Option<Factor<f64>>,
}

impl DenseCholesky {
    /// Room for Hessians of `pattern`.
    pub fn new(pattern: &BlockPattern) -> Self {
        let dofs = pattern.space().dofs();
        Self {
            pattern: pattern.clone(),
            free: FreeDofs::new(dofs),
            scaling: vec![1.0; dofs],
            residual: vec![0.0; dofs],
            correction: vec![0.0; dofs],
            single: Factor::new(dofs),
            double: None,
        }
    }

    /// The steps of `solve` in f32; `None` where f32 does not serve.
    fn solve_single(
        &mut self,
        hessian: &[[f64; 9]],
        gradient: &[f64],
        fixed: &[bool],
        step: &mut [f64],
    ) -> Option<SolveReport> {
        self.single
            .factorise(&self.pattern, hessian, &self.free, &self.scaling, 0.0)
            .ok()?;
        (self.single).solve(gradient, &self.free, &self.scaling, step);
        // One refinement: δ −= H⁻¹ (g + H δ).
        self.relative_residual(hessian, gradient, fixed, step);
        let correction = &mut self.correction;
        (self.single).solve(&self.residual, &self.free, &self.scaling, correction);
        for (s, c) in step.iter_mut().zip(&self.correction) {
            *s += c;
        }
        let residual = self.relative_residual(hessian, gradient, fixed, step);
        (residual < SINGLE_PRECISION_RESIDUAL).then_some(SolveReport {
            diagonal_shift: 0.0,
            residual,
        })
    }

    /// |D (g + H δ)| / |D g| over free DoFs; leaves g + H δ in `self.residual`.
    fn relative_residual(
        &mut self,
        hessian: &[[f64; 9]],
        gradient: &[f64],
        fixed: &[bool],
        step: &[f64],
    ) -> f64 {
        multiply_add(&self.pattern, hessian, step, gradient, &mut self.residual);
        scaled_norm(&self.residual, &self.scaling, fixed)
            / scaled_norm(gradient, &self.scaling, fixed)
    }
}

impl LinearSolver for DenseCholesky {
    fn solve_shifted(
        &mut self,
        hessian: &[[f64; 9]],
        gradient: &[f64],
        fixed: &[bool],
        step: &mut [f64],
        shifts: &[f64],
    ) -> Result<SolveReport> {
        self.free.set(fixed);
        diagonal_scaling(&self.pattern, hessian, fixed, &mut self.scaling);
        if scaled_norm(gradient, &self.scaling, fixed) == 0.0 {
            step.fill(0.0);
            return Ok(SolveReport::default());
        }
        if let Some(report) = self.solve_single(hessian, gradient, fixed, step) {
            return Ok(report);
        }
        let mut double = self
            .double
            .take()
            .unwrap_or_else(|| Factor::new(gradient.len()));
        let mut pivot = 0;
        for &diagonal_shift in shifts {
            let (pattern, free) = (&self.pattern, &self.free);
            match double.factorise(pattern, hessian, free, &self.scaling, diagonal_shift) {
                Err(index) => pivot = free.dofs[index],
                Ok(()) => {
                    double.solve(gradient, free, &self.scaling, step);
                    self.double = Some(double);
                    let residual = self.relative_residual(hessian, gradient, fixed, step);
                    return Ok(SolveReport {
                        diagonal_shift,
                        residual,
                    });
                }
            }
        }
        self.double = Some(double);
        Err(Error::Solve {
            system: "reduced Newton system",
            problem: format!(
                "not positive definite at DoF {pivot}, even with {} added to its scaled diagonal",
                shifts.last().unwrap_or(&0.0)
            ),
        })
    }
}

/// Which DoFs the matrix has, in order.
struct FreeDofs {
    dofs: Vec<usize>,
    /// Row of each DoF in the matrix; none of a fixed one.
    rows: Vec<Option<usize>>,
}

impl FreeDofs {
    /// All of `count`, and room for them.
    fn new(count: usize) -> Self {
        Self {
            dofs: (0..count).collect(),
            rows: (0..count).map(Some).collect(),
        }
    }

    /// Those that are not `fixed`.
    fn set(&mut self, fixed: &[bool]) {
        self.dofs.clear();
        for ((dof, fixed), row) in fixed.iter().enumerate().zip(&mut self.rows) {
            *row = (!fixed).then_some(self.dofs.len());
            if !fixed {
                self.dofs.push(dof);
            }
        }
    }

    /// Rows of the three DoFs of `block`.
    fn rows_of(&self, block: usize) -> [Option<usize>; 3] {
        [0, 1, 2].map(|axis| self.rows[3 * block + axis])
    }
}

/// A dense Cholesky factor with its scratch memory: room for all DoFs, of which the free ones use the corner.
struct Factor<T> {
    matrix: Mat<T>,
    right_hand_side: Mat<T>,
    scratch: MemBuffer,
}

/// The two precisions.
pub(super) trait Real: faer::traits::RealField + Copy {
    fn from_f64(value: f64) -> Self;
    fn to_f64(self) -> f64;
}

impl Real for f32 {
    fn from_f64(value: f64) -> Self {
        value as f32
    }
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

impl Real for f64 {
    fn from_f64(value: f64) -> Self {
        value
    }
    fn to_f64(self) -> f64 {
        self
    }
}

impl<T: Real> Factor<T> {
    fn new(dofs: usize) -> Self {
        let factorise = factor::cholesky_in_place_scratch::<T>(dofs, Par::Seq, Spec::default());
        let solve = solve::solve_in_place_scratch::<T>(dofs, 1, Par::Seq);
        Self {
            matrix: Mat::zeros(dofs, dofs),
            right_hand_side: Mat::zeros(dofs, 1),
            scratch: MemBuffer::new(factorise.or(solve)),
        }
    }

    /// L Lᵀ = D H D + shift I over free DoFs; the row of the failing pivot otherwise.
    fn factorise(
        &mut self,
        pattern: &BlockPattern,
        hessian: &[[f64; 9]],
        free: &FreeDofs,
        scaling: &[f64],
        shift: f64,
    ) -> std::result::Result<(), usize> {
        let count = free.dofs.len();
        for column in 0..count {
            self.matrix.col_as_slice_mut(column)[..count].fill(T::from_f64(0.0));
        }
        for (block, (row, column)) in hessian.iter().zip(pattern.blocks()) {
            let (rows, columns) = (free.rows_of(row), free.rows_of(column));
            for (j, &to) in columns.iter().enumerate() {
                let Some(to) = to else { continue };
                let out = self.matrix.col_as_slice_mut(to);
                for (i, &at) in rows.iter().enumerate() {
                    let Some(at) = at else { continue };
                    let (left, right) = (scaling[3 * row + i], scaling[3 * column + j]);
                    out[at] = T::from_f64(left * block[3 * j + i] * right);
                }
            }
        }
        for k in 0..count {
            self.matrix[(k, k)] += T::from_f64(shift);
        }
        factor::cholesky_in_place(
            self.matrix.as_mut().submatrix_mut(0, 0, count, count),
            Default::default(),
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Spec::default(),
        )
        .map_err(|factor::LltError::NonPositivePivot { index }| index)?;
        // A NaN pivot is not positive either.
        let positive = |k: usize| self.matrix[(k, k)].to_f64() > 0.0;
        match (0..count).find(|&k| !positive(k)) {
            Some(index) => Err(index),
            None => Ok(()),
        }
    }

    /// δ = −D (L Lᵀ)⁻¹ D g over free DoFs, 0 over fixed ones.
    fn solve(&mut self, gradient: &[f64], free: &FreeDofs, scaling: &[f64], step: &mut [f64]) {
        let count = free.dofs.len();
        for (k, &dof) in free.dofs.iter().enumerate() {
            self.right_hand_side[(k, 0)] = T::from_f64(-scaling[dof] * gradient[dof]);
        }
        solve::solve_in_place(
            self.matrix.as_ref().submatrix(0, 0, count, count),
            self.right_hand_side.as_mut().submatrix_mut(0, 0, count, 1),
            Par::Seq,
            MemStack::new(&mut self.scratch),
        );
        step.fill(0.0);
        for (k, &dof) in free.dofs.iter().enumerate() {
            step[dof] = scaling[dof] * self.right_hand_side[(k, 0)].to_f64();
        }
    }
}
