//! One Newton iteration as an observer sees it.

use super::report::InstanceReport;
use crate::model::State;

/// What [`Simulation::step_observed`](super::Simulation::step_observed) shows of one instance's Newton iteration: the
/// iterate q and the Newton step δ from it, before the move q ← q + αδ.
#[derive(Clone, Copy, Debug)]
pub struct Iteration<'a> {
    /// Which instance.
    pub instance: usize,
    /// q: in the first iteration where the minimisation starts.
    pub state: &'a State,
    /// g = ∂E/∂q there.
    pub gradient: &'a [f64],
    /// Which DoFs are prescribed: their part of g is what holds them.
    pub fixed: &'a [bool],
    /// δ.
    pub step: &'a [f64],
    /// What the step's report says so far: the iteration's number, its decrement and step length, the energies at q.
    pub report: &'a InstanceReport,
}

/// Called once an iteration for every instance that takes part in it.
pub type Observer<'a> = dyn FnMut(&Iteration<'_>) + Send + 'a;

impl Iteration<'_> {
    /// |g| over the DoFs that are free; N and N·m count alike.
    pub fn gradient_norm(&self) -> f64 {
        let free = self.gradient.iter().zip(self.fixed);
        let squares = free.map(|(g, fixed)| if *fixed { 0.0 } else { g * g });
        squares.sum::<f64>().sqrt()
    }
}
