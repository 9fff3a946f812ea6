//! The bodies of a group: the few DoFs that its members are solved for together.

use super::part::{Attempt, Part};
use crate::sim::linear_solver::SolveReport;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::{factor, solve};
use faer::{Mat, Par, Spec};

/// The system of a group's bodies, and how the group's solve went.
pub(super) struct Shared {
    /// Whether the group runs and has more than one member.
    pub running: bool,
    /// How it was solved; none as long as it is not.
    pub solved: Option<SolveReport>,
    /// By DoF of the bodies: d with d² H_ii = 1.
    pub scaling: Vec<f64>,
    pub fixed: Vec<bool>,
    /// |D g| of the group.
    pub gradient_norm: f64,
    residual: Vec<f64>,
    matrix: Mat<f64>,
    right_hand_side: Mat<f64>,
    scratch: MemBuffer,
}

impl Default for Shared {
    fn default() -> Self {
        Self {
            running: false,
            solved: None,
            scaling: Vec::new(),
            fixed: Vec::new(),
            gradient_norm: 0.0,
            residual: Vec::new(),
            matrix: Mat::zeros(0, 0),
            right_hand_side: Mat::zeros(0, 1),
            scratch: MemBuffer::new(solve::solve_in_place_scratch::<f64>(0, 1, Par::Seq)),
        }
    }
}

impl Shared {
    /// Starts with the system of `dofs` DoFs, none of them fixed, their scaling to be summed up.
    pub fn begin(&mut self, dofs: usize) {
        self.solved = None;
        self.scaling.clear();
        self.scaling.resize(dofs, 0.0);
        self.fixed.clear();
        self.fixed.resize(dofs, false);
        if self.matrix.nrows() < dofs {
            self.matrix = Mat::zeros(dofs, dofs);
            self.right_hand_side = Mat::zeros(dofs, 1);
            let factorise =
                factor::cholesky_in_place_scratch::<f64>(dofs, Par::Seq, Spec::default());
            let solve = solve::solve_in_place_scratch::<f64>(dofs, 1, Par::Seq);
            self.scratch = MemBuffer::new(factorise.or(solve));
        }
    }

    /// From the sums of the members' diagonals to d.
    pub fn finish_scaling(&mut self) {
        for scaling in &mut self.scaling {
            let positive = *scaling > 0.0;
            *scaling = if positive {
                scaling.sqrt().recip()
            } else {
                1.0
            };
        }
    }

    /// |D (g + H δ)| of the group.
    pub fn residual_norm(&mut self, parts: &[Part], members: &[usize]) -> f64 {
        self.residual.clear();
        self.residual.resize(self.scaling.len(), 0.0);
        let mut squares = 0.0;
        for part in members.iter().map(|&i| &parts[i]) {
            squares += part.residual_norm_squared();
            for (dof, z) in part.shared_dofs() {
                self.residual[z] += part.residual[dof];
            }
        }
        for ((r, d), fixed) in self.residual.iter().zip(&self.scaling).zip(&self.fixed) {
            squares += if *fixed { 0.0 } else { (r * d).powi(2) };
        }
        squares.sqrt()
    }

    /// Solves for the move of the bodies and hands it to the members; false where their system is not positive
    /// definite.
    pub fn solve(&mut self, parts: &mut [Part], members: &[usize], attempt: Attempt) -> bool {
        let count = self.scaling.len();
        let mut matrix = self.matrix.as_mut().submatrix_mut(0, 0, count, count);
        let mut z = self.right_hand_side.as_mut().submatrix_mut(0, 0, count, 1);
        matrix.fill(0.0);
        z.fill(0.0);
        for part in members.iter().map(|&i| &parts[i]) {
            let n = part.places.shared;
            for column in 0..n {
                let c = part.of_group(column);
                z[(c, 0)] += part.reduced[column];
                for row in 0..n {
                    matrix[(part.of_group(row), c)] += part.schur[column * n + row];
                }
            }
        }
        for k in 0..count {
            if let Attempt::Double(shift) = attempt {
                matrix[(k, k)] += shift;
            }
            if self.fixed[k] {
                matrix.as_mut().row_mut(k).fill(0.0);
                matrix.as_mut().col_mut(k).fill(0.0);
                matrix[(k, k)] = 1.0;
                z[(k, 0)] = 0.0;
            }
        }
        let factored = factor::cholesky_in_place(
            matrix.as_mut(),
            Default::default(),
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Spec::default(),
        );
        // A NaN pivot is not positive either.
        if factored.is_err() || !(0..count).all(|k| matrix[(k, k)] > 0.0) {
            return false;
        }
        let stack = MemStack::new(&mut self.scratch);
        solve::solve_in_place(matrix.as_ref(), z.as_mut(), Par::Seq, stack);
        for &i in members {
            let part = &mut parts[i];
            for k in 0..part.places.shared {
                part.moved[k] = z[(part.of_group(k), 0)];
            }
        }
        true
    }
}
