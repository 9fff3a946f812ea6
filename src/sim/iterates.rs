//! Where the instances of a batch are, and E with its derivatives there.

use super::members::Members;
use super::minimisation::Minimisation;
use super::report::Timings;
use super::solvers::Systems;
use crate::Result;
use crate::math::{Stopwatch, par_members};
use crate::model::State;
use crate::potential::{Evaluation, HessianForm};
use crate::skeleton::SkeletonEnergies;

/// One iterate q for each instance, and what its last evaluation said.
#[derive(Default)]
pub(super) struct Iterates {
    /// q.
    pub states: Vec<State>,
    /// E(q) − E(qⁿ) of the tissue; gradient and Hessian of tissue and skeleton.
    pub evaluations: Vec<Evaluation>,
    /// E(q) − E(qⁿ) of the skeleton.
    pub skeleton_energies: Vec<SkeletonEnergies>,
    /// Memory: whose Hessian is exact.
    exact: Vec<bool>,
}

impl Iterates {
    /// Room for states like these.
    pub fn new(states: Vec<State>) -> Self {
        let count = states.len();
        Self {
            states,
            evaluations: vec![Evaluation::default(); count],
            skeleton_energies: vec![SkeletonEnergies::default(); count],
            exact: vec![false; count],
        }
    }

    /// Evaluates tissue and skeleton where `wanted`.
    pub async fn evaluate<M: Members>(
        &mut self,
        members: &mut M,
        minimisations: &[Minimisation],
        systems: &Systems,
        wanted: &[bool],
        timings: &mut Timings,
    ) -> Result<()> {
        let watch = Stopwatch::start();
        members
            .evaluate(&self.states, wanted, &mut self.evaluations)
            .await?;
        timings.evaluation += watch.ms();
        let watch = Stopwatch::start();
        for (i, exact) in self.exact.iter_mut().enumerate() {
            *exact = wanted[i] && members.hessian_form(i) == HessianForm::Exact;
        }
        let (states, exact) = (&self.states, &self.exact);
        let parts = (&mut self.evaluations[..], &mut self.skeleton_energies[..]);
        par_members(wanted.len(), parts, |i, (evaluation, energies)| {
            if !wanted[i] {
                return;
            }
            let (state, minimisation) = (&states[i], &minimisations[i]);
            let Evaluation {
                gradient, hessian, ..
            } = evaluation;
            let pattern = systems.pattern(i);
            minimisation.add_derivatives(state, exact[i], gradient, hessian, pattern);
            *energies = minimisation.skeleton_difference(&minimisation.current, state);
        });
        timings.skeleton += watch.ms();
        Ok(())
    }

    /// Takes the memory that evaluations of `other`'s took, so that none is taken when it is needed.
    pub fn make_room_like(&mut self, other: &Self) {
        for (own, other) in self.evaluations.iter_mut().zip(&other.evaluations) {
            if own.gradient.is_empty() && !other.gradient.is_empty() {
                own.clone_from(other);
            }
        }
    }

    /// E(q) − E(qⁿ) of a group's members together.
    pub fn energy(&self, members: &[usize]) -> f64 {
        let energy =
            |&i: &usize| self.evaluations[i].energies.total() + self.skeleton_energies[i].total();
        members.iter().map(energy).sum()
    }

    /// Exchanges an instance's iterate, with all that is known there, for that in `other`.
    pub fn swap(&mut self, i: usize, other: &mut Self) {
        std::mem::swap(&mut self.states[i], &mut other.states[i]);
        std::mem::swap(&mut self.evaluations[i], &mut other.evaluations[i]);
        std::mem::swap(
            &mut self.skeleton_energies[i],
            &mut other.skeleton_energies[i],
        );
    }
}
