//! Prescribed frames: no blocks of the Hessian, and all else to the bit as without; and what a step's end tells.

use super::case::cases;
use super::evaluate;
use pollster::block_on;
use std::sync::Arc;
use supple::internal::cpu::Exact;
use supple::model::State;
use supple::potential::{CpuPotential, Evaluation, Potential, StepEnd};

/// The first bone and the body.
const PRESCRIBED: [usize; 2] = [0, 3];

#[test]
fn blocks_of_prescribed_frames_are_zero_and_the_rest_has_the_same_bits() {
    let case = cases().pop().unwrap();
    let [previous, current, state] = &case.states();
    let mut potential = case.reference();
    let free = evaluate(&mut potential, state);
    let mut exact = Exact(case.reference());
    let exact_free = evaluate_exact(&mut exact, state);
    let frames = case.avatar.skeleton.len();
    let prescribed: Vec<bool> = (0..frames).map(|f| PRESCRIBED.contains(&f)).collect();
    let mut start = case.start(previous, current);
    start.prescribed = &prescribed;
    block_on(potential.begin_step(&[start], &[true])).unwrap();
    let held = evaluate(&mut potential, state);
    assert_eq!(held.gradient, free.gradient);
    assert_eq!(held.energies, free.energies);
    assert_eq!(held.contact_force, free.contact_force);
    block_on(exact.begin_step(&[start], &[true])).unwrap();
    let exact_held = evaluate_exact(&mut exact, state);

    let is_prescribed = |block: usize| block < 2 * frames && prescribed[block / 2];
    let (mut left_out, mut geometric) = (0, 0);
    for (k, (row, column)) in potential.pattern().blocks().enumerate() {
        if is_prescribed(row) || is_prescribed(column) {
            assert_eq!(held.hessian[k], [0.0; 9], "({row}, {column})");
            assert_eq!(held.geometric[k], [0.0; 9], "({row}, {column})");
            assert_eq!(exact_held.hessian[k], [0.0; 9], "({row}, {column})");
            left_out += usize::from(free.hessian[k] != [0.0; 9]);
            geometric += usize::from(free.geometric[k] != [0.0; 9]);
        } else {
            assert_eq!(held.hessian[k], free.hessian[k], "({row}, {column})");
            assert_eq!(held.geometric[k], free.geometric[k], "({row}, {column})");
            assert_eq!(exact_held.hessian[k], exact_free.hessian[k]);
        }
    }
    assert!(left_out > 20 && geometric > 5, "{left_out}, {geometric}");

    // The next step prescribes nothing, and one for too many frames is refused.
    block_on(potential.begin_step(&[case.start(previous, current)], &[true])).unwrap();
    assert_eq!(evaluate(&mut potential, state), free);
    let many = vec![false; frames + 1];
    start.prescribed = &many;
    let error = block_on(potential.begin_step(&[start], &[true])).unwrap_err();
    assert!(error.to_string().contains("prescribed"), "{error}");
}

fn evaluate_exact(potential: &mut Exact, state: &State) -> Evaluation {
    let mut out = [Evaluation::default()];
    block_on(potential.evaluate(std::slice::from_ref(state), &[true], &mut out)).unwrap();
    let [evaluation] = out;
    evaluation
}

#[test]
fn a_steps_end_tells_what_an_evaluation_tells_of_frames() {
    let case = cases().pop().unwrap();
    let [_, current, state] = case.states();
    let states = [state, current];
    let avatar = Arc::new(case.avatar.clone());
    let mut potential = case.begun(CpuPotential::new(avatar, 2).unwrap());
    let mut whole = vec![Evaluation::default(); 2];
    block_on(potential.evaluate(&states, &[true; 2], &mut whole)).unwrap();
    let mut ends = vec![StepEnd::default(); 2];
    block_on(potential.end_step(&states, &[true, false], &mut ends)).unwrap();
    let expected = StepEnd {
        energies: whole[0].energies,
        frame_gradient: whole[0].gradient[..6 * case.avatar.skeleton.len()].to_vec(),
        contact_force: whole[0].contact_force,
        contacts: whole[0].contacts,
        contacts_left_out: 0,
    };
    assert_eq!(ends, [expected, StepEnd::default()]);
    assert!(ends[0].contacts > 10 && ends[0].energies.friction != 0.0);
    // And what is evaluated after it is none the worse for it.
    let mut again = vec![Evaluation::default(); 2];
    block_on(potential.evaluate(&states, &[true; 2], &mut again)).unwrap();
    assert_eq!(again, whole);

    let mut broken = states.clone();
    broken[0].handles[1].x = f64::NAN;
    assert!(block_on(potential.end_step(&broken, &[true; 2], &mut ends)).is_err());
    broken[0].handles[1].x = 1e200;
    assert!(block_on(potential.end_step(&broken, &[true; 2], &mut ends)).is_err());
}
