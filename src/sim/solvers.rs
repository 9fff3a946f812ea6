//! Solvers of the reduced systems, one for each thread that solves at a time.

use super::dense_cholesky::DenseCholesky;
use super::linear_solver::LinearSolver;
use crate::math::{thread_index, threads};
use crate::potential::BlockPattern;
use std::sync::{Mutex, PoisonError};

/// Solvers that are interchangeable; which one serves does not show in a result.
pub(super) struct Solvers(Vec<Mutex<Box<dyn LinearSolver + Send>>>);

impl Solvers {
    /// As many as may be of use at once for `systems` systems of `pattern`.
    pub fn dense(pattern: &BlockPattern, systems: usize) -> Self {
        let one = |_| Mutex::new(Box::new(DenseCholesky::new(pattern)) as _);
        Self((0..threads().min(systems).max(1)).map(one).collect())
    }

    /// One that serves all systems in turn.
    pub fn one(solver: Box<dyn LinearSolver + Send>) -> Self {
        Self(vec![Mutex::new(solver)])
    }

    /// Whether systems must be solved in turn.
    pub fn is_single(&self) -> bool {
        self.0.len() == 1
    }

    /// Lends the solver of this thread.
    pub fn lend<R>(&self, f: impl FnOnce(&mut dyn LinearSolver) -> R) -> R {
        let solver = &self.0[thread_index() % self.0.len()];
        // A solver makes its factor anew each time: one whose thread panicked serves as well.
        f(&mut **solver.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
