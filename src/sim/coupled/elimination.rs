//! A member of a group without its own DoFs: what is left is a system of the bodies that it touches.

use crate::potential::BlockPattern;
use crate::sim::dense_cholesky::Real;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::llt::factor;
use faer::linalg::matmul::matmul;
use faer::linalg::triangular_solve::{
    solve_lower_triangular_in_place, solve_upper_triangular_in_place,
};
use faer::{Accum, Mat, Par, Spec};

/// Place of a DoF that does not move.
pub(super) const FIXED: u32 = u32::MAX;

/// Where the DoFs of a member's state stand in its group's system: its own free ones first, numbered from 0; then
/// those of the frames that stand for bodies.
#[derive(Clone, Debug, Default)]
pub(super) struct Places {
    /// By DoF of the member's state; [`FIXED`] where it does not move.
    pub of_dof: Vec<u32>,
    /// Number of its own free DoFs.
    pub own: usize,
    /// Number of the bodies' DoFs.
    pub shared: usize,
}

/// With A the member's own free DoFs of D H D, K the rows that couple a body's DoFs to them: L Lᵀ = A, W = L⁻¹ Kᵀ.
pub(super) struct Elimination<T> {
    factor: Mat<T>,
    coupling: Mat<T>,
    right_hand_side: Mat<T>,
    product: Mat<T>,
    scratch: MemBuffer,
}

impl<T: Real> Elimination<T> {
    /// Room for `dofs` DoFs, bodies' included.
    pub fn new(dofs: usize) -> Self {
        let scratch = factor::cholesky_in_place_scratch::<T>(dofs, Par::Seq, Spec::default());
        Self {
            factor: Mat::zeros(dofs, dofs),
            coupling: Mat::zeros(dofs, 0),
            right_hand_side: Mat::zeros(dofs, 1),
            product: Mat::zeros(0, 1),
            scratch: MemBuffer::new(scratch),
        }
    }

    /// Eliminates the member's own DoFs of the packed `hessian`, scaled by `scaling`, with `shift` added to A. Adds
    /// the bodies' part C − Wᵀ W to `schur`, column by column; false where A is not positive definite.
    pub fn factorise(
        &mut self,
        (pattern, hessian): (&BlockPattern, &[[f64; 9]]),
        places: &Places,
        scaling: &[f64],
        shift: f64,
        schur: &mut [f64],
    ) -> bool {
        let (own, shared) = (places.own, places.shared);
        if self.coupling.ncols() < shared {
            self.coupling = Mat::zeros(self.factor.nrows(), shared);
            self.product = Mat::zeros(shared, shared);
        }
        self.factor.fill(T::from_f64(0.0));
        self.coupling.fill(T::from_f64(0.0));
        schur.fill(0.0);
        for (block, (row, column)) in hessian.iter().zip(pattern.blocks()) {
            for j in 0..3 {
                for i in 0..3 {
                    let (r, c) = (3 * row + i, 3 * column + j);
                    // A diagonal block stands whole where it counts in its lower triangle.
                    let (a, b) = (places.of_dof[r], places.of_dof[c]);
                    if a == FIXED || b == FIXED || r < c {
                        continue;
                    }
                    let (high, low) = (a.max(b) as usize, a.min(b) as usize);
                    let value = scaling[r] * block[3 * j + i] * scaling[c];
                    if high < own {
                        self.factor[(high, low)] = T::from_f64(value);
                    } else if low < own {
                        self.coupling[(low, high - own)] = T::from_f64(value);
                    } else {
                        let (high, low) = (high - own, low - own);
                        schur[low * shared + high] = value;
                        schur[high * shared + low] = value;
                    }
                }
            }
        }
        for k in 0..own {
            self.factor[(k, k)] += T::from_f64(shift);
        }
        let factored = factor::cholesky_in_place(
            self.factor.as_mut().submatrix_mut(0, 0, own, own),
            Default::default(),
            Par::Seq,
            MemStack::new(&mut self.scratch),
            Spec::default(),
        );
        // A NaN pivot is not positive either.
        let positive = |k: usize| self.factor[(k, k)].to_f64() > 0.0;
        if factored.is_err() || !(0..own).all(positive) {
            return false;
        }
        let factor = self.factor.as_ref().submatrix(0, 0, own, own);
        let mut coupling = self.coupling.as_mut().submatrix_mut(0, 0, own, shared);
        solve_lower_triangular_in_place(factor, coupling.as_mut(), Par::Seq);
        let coupling = coupling.as_ref();
        let mut product = self.product.as_mut().submatrix_mut(0, 0, shared, shared);
        let one = T::from_f64(1.0);
        matmul(
            product.as_mut(),
            Accum::Replace,
            coupling.transpose(),
            coupling,
            one,
            Par::Seq,
        );
        for c in 0..shared {
            for r in 0..shared {
                schur[c * shared + r] -= product[(r, c)].to_f64();
            }
        }
        true
    }

    /// y = −L⁻¹ D r of the member's own part of the residual `r`, kept; −D r − Wᵀ y of the bodies' goes to `reduced`.
    pub fn forward(
        &mut self,
        places: &Places,
        scaling: &[f64],
        residual: &[f64],
        reduced: &mut [f64],
    ) {
        let (own, shared) = (places.own, places.shared);
        for (dof, &place) in places.of_dof.iter().enumerate() {
            let value = -scaling[dof] * residual[dof];
            match place as usize {
                place if place < own => self.right_hand_side[(place, 0)] = T::from_f64(value),
                place if place < own + shared => reduced[place - own] = value,
                _ => (),
            }
        }
        let factor = self.factor.as_ref().submatrix(0, 0, own, own);
        let mut y = self.right_hand_side.as_mut().submatrix_mut(0, 0, own, 1);
        solve_lower_triangular_in_place(factor, y.as_mut(), Par::Seq);
        let coupling = self.coupling.as_ref().submatrix(0, 0, own, shared);
        for (c, reduced) in reduced.iter_mut().enumerate() {
            let (w, y) = (coupling.col(c), y.as_ref().col(0));
            let products = (0..own).map(|k| w[k].to_f64() * y[k].to_f64());
            *reduced -= products.sum::<f64>();
        }
    }

    /// Adds x = D L⁻ᵀ (y − W z) to `step`, where z is the (scaled) move of the bodies' DoFs.
    pub fn backward(&mut self, places: &Places, scaling: &[f64], z: &[f64], step: &mut [f64]) {
        let (own, shared) = (places.own, places.shared);
        let coupling = self.coupling.as_ref().submatrix(0, 0, own, shared);
        let mut x = self.right_hand_side.as_mut().submatrix_mut(0, 0, own, 1);
        for k in 0..own {
            let moved: f64 = (0..shared).map(|c| coupling[(k, c)].to_f64() * z[c]).sum();
            x[(k, 0)] = T::from_f64(x[(k, 0)].to_f64() - moved);
        }
        let factor = self.factor.as_ref().submatrix(0, 0, own, own);
        solve_upper_triangular_in_place(factor.transpose(), x.as_mut(), Par::Seq);
        for (dof, &place) in places.of_dof.iter().enumerate() {
            let place = place as usize;
            if place < own {
                step[dof] += scaling[dof] * x[(place, 0)].to_f64();
            } else if place < own + shared {
                step[dof] += scaling[dof] * z[place - own];
            }
        }
    }
}
