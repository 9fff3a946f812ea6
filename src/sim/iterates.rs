//! Where the instances of a batch are, and E with its derivatives there.

use super::minimisation::Minimisation;
use super::report::Timings;
use crate::Result;
use crate::math::Stopwatch;
use crate::model::State;
use crate::potential::{Evaluation, HessianForm, Potential};
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
}

impl Iterates {
    /// Room for `count` instances like `rest`.
    pub fn new(count: usize, rest: &State) -> Self {
        Self {
            states: vec![rest.clone(); count],
            evaluations: vec![Evaluation::default(); count],
            skeleton_energies: vec![SkeletonEnergies::default(); count],
        }
    }

    /// Evaluates tissue and skeleton where `wanted`.
    pub async fn evaluate<P: Potential>(
        &mut self,
        potential: &mut P,
        minimisations: &[Minimisation],
        wanted: &[bool],
        timings: &mut Timings,
    ) -> Result<()> {
        let watch = Stopwatch::start();
        potential
            .evaluate(&self.states, wanted, &mut self.evaluations)
            .await?;
        timings.evaluation += watch.ms();
        let watch = Stopwatch::start();
        for (i, minimisation) in minimisations.iter().enumerate().filter(|(i, _)| wanted[*i]) {
            let (frames, skeleton) = (&self.states[i].frames, &minimisation.skeleton);
            let Evaluation {
                gradient, hessian, ..
            } = &mut self.evaluations[i];
            skeleton.add_derivatives(frames, gradient, hessian);
            if potential.hessian_form() == HessianForm::Exact {
                skeleton.add_geometric(frames, hessian);
            }
            self.skeleton_energies[i] = skeleton.difference(&minimisation.current.frames, frames);
        }
        timings.skeleton += watch.ms();
        Ok(())
    }

    /// E(q) − E(qⁿ) of an instance.
    pub fn energy(&self, i: usize) -> f64 {
        self.evaluations[i].energies.total() + self.skeleton_energies[i].total()
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
