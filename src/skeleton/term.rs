//! What an energy of the bones' frames provides.

use crate::model::Frame;
use crate::potential::BlockPattern;
use glam::{DMat3, DVec3};

/// An energy of frames.
pub trait FrameTerm {
    /// E(frames) − E(base), J, from increments.
    fn difference(&self, base: &[Frame], frames: &[Frame]) -> f64;

    /// Adds ∂E/∂(c, ω) into `gradient` (three scalars a block, [`Space`](crate::model::Space) order)
    /// and the positive semi-definite Gauss–Newton Hessian into `hessian`.
    fn add_derivatives(
        &self,
        frames: &[Frame],
        gradient: &mut [f64],
        hessian: &mut FrameHessian<'_>,
    );

    /// Adds what the Gauss–Newton Hessian leaves out, force times second derivatives of positions, symmetrised over
    /// the order of two rotations. With it the Hessian is exact, and may be indefinite.
    fn add_geometric(&self, frames: &[Frame], hessian: &mut FrameHessian<'_>);
}

/// R_pᵀ R_j: how a bone is turned as its parent sees it.
pub(super) fn relative_rotation(frames: &[Frame], parent: usize, child: usize) -> DMat3 {
    frames[parent].rotation.transpose() * frames[child].rotation
}

/// The symmetric C with f · x″ = ωᵀCω at t = 0, where x(t) = exp(t\[ω\]) a: ½ (f aᵀ + a fᵀ) − (f·a) I.
pub fn rotation_curvature(f: DVec3, a: DVec3) -> DMat3 {
    let outer = DMat3::from_cols(f * a.x, f * a.y, f * a.z);
    (outer + outer.transpose()) * 0.5 - DMat3::from_diagonal(DVec3::splat(f.dot(a)))
}

/// The frame–frame part of a packed Hessian.
pub struct FrameHessian<'a> {
    blocks: &'a mut [[f64; 9]],
    /// None of one that takes nothing.
    pattern: Option<&'a BlockPattern>,
}

impl<'a> FrameHessian<'a> {
    /// Of the `packed` blocks of `pattern`.
    pub fn new(packed: &'a mut [[f64; 9]], pattern: &'a BlockPattern) -> Self {
        Self {
            blocks: packed,
            pattern: Some(pattern),
        }
    }

    /// Takes nothing: for gradients alone.
    pub fn none() -> Self {
        Self {
            blocks: &mut [],
            pattern: None,
        }
    }

    /// Adds `value` to block (`row`, `column`), and by symmetry its transpose to (`column`, `row`).
    /// A block on the diagonal is added once.
    pub fn add(&mut self, row: usize, column: usize, value: DMat3) {
        let Some(pattern) = self.pattern else {
            return;
        };
        let (row, column, value) = if row >= column {
            (row, column, value)
        } else {
            (column, row, value.transpose())
        };
        // A block that the pattern lacks is of carried bones, which have no terms.
        let Some(at) = pattern.find(row, column) else {
            return;
        };
        let block = &mut self.blocks[at];
        for (entry, v) in block.iter_mut().zip(value.to_cols_array()) {
            *entry += v;
        }
    }
}

/// A residual r of a term ½k|r|² and its derivatives ∂r/∂(block).
pub struct Residual<const N: usize> {
    /// (block, ∂r/∂block).
    pub jacobian: [(usize, DMat3); N],
}

impl<const N: usize> Residual<N> {
    /// Gradient Jᵀ f, with f = ∂E/∂r.
    pub fn add_gradient(&self, f: DVec3, gradient: &mut [f64]) {
        for (block, jacobian) in &self.jacobian {
            add_block(gradient, *block, jacobian.transpose() * f);
        }
    }

    /// Gauss–Newton Hessian k JᵀJ.
    pub fn add_hessian(&self, k: f64, hessian: &mut FrameHessian<'_>) {
        if hessian.pattern.is_none() {
            return;
        }
        for (i, (row, left)) in self.jacobian.iter().enumerate() {
            for (column, right) in &self.jacobian[..=i] {
                hessian.add(*row, *column, left.transpose() * *right * k);
            }
        }
    }
}

/// Adds a 3-vector to a block of a gradient.
pub(super) fn add_block(gradient: &mut [f64], block: usize, value: DVec3) {
    for (entry, v) in gradient[3 * block..3 * block + 3]
        .iter_mut()
        .zip(value.to_array())
    {
        *entry += v;
    }
}
