//! What the room asks of an energy.

use supple::internal::cpu::HessianForm;

/// Which DoF of the checked state is moved, and how far (m or rad); `None` moves nothing.
pub type Moved = Option<(usize, f64)>;

/// An energy about one state, far from rest unless said otherwise.
pub trait Energy {
    /// E(q moved by `to`) − E(q moved by `from`), J.
    fn difference(&mut self, from: Moved, to: Moved) -> f64;

    /// ∂E/∂q at the state moved by `at`.
    fn gradient(&mut self, at: Moved) -> Vec<f64>;

    /// `Solver` is what Newton gets.
    fn hessian(&mut self, form: HessianForm) -> Vec<Vec<f64>>;

    /// The solver's Hessian made in another way: Σ over points of Jᵀ K J with the projected tangent.
    fn stated_projection(&mut self) -> Option<Vec<Vec<f64>>> {
        None
    }
}

/// A line of the table.
pub struct Term {
    /// What failures name.
    pub name: String,
    /// The energy alone.
    pub energy: Box<dyn Energy>,
    /// The same where its residual vanishes: there Gauss–Newton is exact.
    pub at_rest: Option<Box<dyn Energy>>,
    /// Whether the solver's Hessian is 0: the energy is linear in positions.
    pub linear: bool,
}

pub fn largest<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    values.into_iter().fold(0.0, |a, x| f64::max(a, x.abs()))
}

pub fn largest_entry(matrix: &[Vec<f64>]) -> f64 {
    largest(matrix.iter().flatten())
}
