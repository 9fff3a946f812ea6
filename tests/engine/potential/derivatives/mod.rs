//! The incremental potential of the f64 evaluation against differences of itself, on a random avatar far
//! from rest, moving, with every collider shape in touch: each term alone, and all of them.

mod basis;
mod case;
mod factors;
mod fine;
mod prescribed;
mod terms;

use pollster::block_on;
use supple::model::State;
use supple::potential::{CpuPotential, Difference, Evaluation, Potential, Trial};

fn evaluate<B: supple::internal::cpu::Basis>(
    potential: &mut CpuPotential<B>,
    state: &State,
) -> Evaluation {
    let mut out = [Evaluation::default()];
    block_on(potential.evaluate(std::slice::from_ref(state), &[true], &mut out)).unwrap();
    let [evaluation] = out;
    evaluation
}

fn difference(potential: &mut CpuPotential, base: &State, state: &State) -> f64 {
    let trial = Trial {
        instance: 0,
        base,
        state,
    };
    let mut out = [Difference::default()];
    block_on(potential.energy_differences(&[trial], &mut out)).unwrap();
    out[0].energy
}

fn unit(dofs: usize, k: usize) -> Vec<f64> {
    (0..dofs).map(|i| f64::from(u8::from(i == k))).collect()
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |a, x| f64::max(a, x.abs()))
}

/// Sizes of the steps of differences: 1e-5 of a length of some cm, and below 1e-2 of the slips, whose third
/// derivative is the largest.
const STEP: f64 = 2e-7;
