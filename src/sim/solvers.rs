//! The linear systems of all members, and who solves them.

use super::dense_cholesky::DenseCholesky;
use super::linear_solver::LinearSolver;
use crate::math::{thread_index, threads};
use crate::potential::BlockPattern;
use std::sync::{Mutex, PoisonError};

/// What solves the systems of one asset: as many solvers as threads solve at a time. They are interchangeable: which one
/// serves does not show in a result.
pub(crate) struct Solvers {
    pattern: BlockPattern,
    solvers: Vec<Mutex<Box<dyn LinearSolver + Send>>>,
}

impl Solvers {
    /// As many as may be of use at once for `systems` systems of `pattern`.
    pub fn dense(pattern: &BlockPattern, systems: usize) -> Self {
        let one = |_| Mutex::new(Box::new(DenseCholesky::new(pattern)) as _);
        Self {
            pattern: pattern.clone(),
            solvers: (0..threads().min(systems).max(1)).map(one).collect(),
        }
    }

    /// One that serves all systems of `pattern` in turn.
    pub fn one(pattern: &BlockPattern, solver: Box<dyn LinearSolver + Send>) -> Self {
        Self {
            pattern: pattern.clone(),
            solvers: vec![Mutex::new(solver)],
        }
    }
}

/// The systems of a list of members.
#[derive(Default)]
pub(super) struct Systems {
    assets: Vec<Solvers>,
    asset_of: Vec<usize>,
}

impl Systems {
    /// Of members that are of these assets.
    pub fn new(assets: Vec<Solvers>, asset_of: Vec<usize>) -> Self {
        Self { assets, asset_of }
    }

    /// Which blocks the Hessian of a member has.
    pub fn pattern(&self, member: usize) -> &BlockPattern {
        &self.assets[self.asset_of[member]].pattern
    }

    /// Whether members must be solved in turn: the only solver of an asset may use threads itself.
    pub fn in_turn(&self) -> bool {
        self.assets.iter().any(|asset| asset.solvers.len() == 1)
    }

    /// Lends this thread a solver for a member.
    pub fn lend<R>(&self, member: usize, f: impl FnOnce(&mut dyn LinearSolver) -> R) -> R {
        let solvers = &self.assets[self.asset_of[member]].solvers;
        let solver = &solvers[thread_index() % solvers.len()];
        // A solver makes its factor anew each time: one whose thread panicked serves as well.
        f(&mut **solver.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
