//! Batches and threads change no bit.

use super::{avatar, floor, start};
use pollster::block_on;
use std::sync::Arc;
use supple::glam::DVec3;
use supple::internal::random_state;
use supple::model::{Avatar, State};
use supple::potential::{CpuPotential, Difference, Evaluation, Potential, Trial};

/// Two steps' start states and one to evaluate, for each of three instances.
pub fn triples(avatar: &Avatar) -> Vec<[State; 3]> {
    let state = |seed| random_state(seed, avatar, 0.3, 0.003);
    (0..3)
        .map(|k| [state(10 * k), state(10 * k + 1), state(10 * k + 2)])
        .collect()
}

/// Evaluations of all `triples` in one batch, with the trial differences and the drawn skins.
fn run(avatar: &Arc<Avatar>, triples: &[[State; 3]]) -> Vec<(Evaluation, f64, Vec<DVec3>)> {
    let colliders: Vec<_> = (0..triples.len())
        .map(|k| [floor(-0.02 + 0.004 * k as f64), floor(-0.025)])
        .collect();
    let mut potential = CpuPotential::new(avatar.clone(), triples.len()).unwrap();
    let starts: Vec<_> = triples
        .iter()
        .zip(&colliders)
        .map(|([previous, current, _], colliders)| start(previous, current, colliders))
        .collect();
    let states: Vec<_> = triples.iter().map(|t| t[2].clone()).collect();
    let trials: Vec<_> = (0..triples.len())
        .map(|k| Trial {
            instance: k,
            base: &triples[k][0],
            state: &triples[k][2],
        })
        .collect();
    let active = vec![true; triples.len()];
    let mut out = vec![Evaluation::default(); triples.len()];
    let mut differences = vec![Difference::default(); triples.len()];
    block_on(async {
        potential.begin_step(&starts, &active).await.unwrap();
        potential
            .evaluate(&states, &active, &mut out)
            .await
            .unwrap();
        potential
            .energy_differences(&trials, &mut differences)
            .await
            .unwrap();
        potential.pose_skin(&states, &[], &[]).await.unwrap();
    });
    let mut skin = |k| {
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        block_on(potential.read_skin(k, &mut positions, &mut normals)).unwrap();
        positions.extend(normals);
        positions
    };
    let results = out.into_iter().zip(differences).enumerate();
    results
        .map(|(k, (evaluation, difference))| (evaluation, difference.energy, skin(k)))
        .collect()
}

fn assert_same_bits(a: &(Evaluation, f64, Vec<DVec3>), b: &(Evaluation, f64, Vec<DVec3>)) {
    assert!(a.0.contacts > 0 && a.0.contacts == b.0.contacts);
    assert_eq!(a.0.energies, b.0.energies);
    assert_eq!(a.0.contact_force, b.0.contact_force);
    assert_eq!(a.0.gradient, b.0.gradient);
    assert_eq!(a.0.hessian, b.0.hessian);
    assert_eq!((a.1, &a.2), (b.1, &b.2));
}

#[test]
fn three_instances_at_once_give_the_bits_of_lone_runs() {
    let avatar = avatar();
    let triples = triples(&avatar);
    let together = run(&avatar, &triples);
    // Three lone runs, each with the floor of its place in the batch, would need the same colliders:
    // run the batch with the other two replaced instead.
    for k in 0..3 {
        let mut others = triples.clone();
        for other in (0..3).filter(|&other| other != k) {
            others[other] = triples[k].clone();
        }
        assert_same_bits(&together[k], &run(&avatar, &others)[k]);
    }
    let lone = run(&avatar, &triples[..1]);
    assert_same_bits(&together[0], &lone[0]);
    assert_ne!(together[0].0.gradient, together[1].0.gradient);
}

#[cfg(feature = "threads")]
#[test]
fn the_number_of_threads_does_not_change_a_bit() {
    let avatar = avatar();
    let triples = triples(&avatar);
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| run(&avatar, &triples))
    };
    let (one, five) = (with(1), with(5));
    for (a, b) in one.iter().zip(&five) {
        assert_same_bits(a, b);
    }
}

#[test]
fn an_inactive_instance_is_left_alone() {
    let avatar = avatar();
    let [previous, current, state] = &triples(&avatar)[0];
    let mut potential = CpuPotential::new(avatar.clone(), 2).unwrap();
    let starts = [start(previous, current, &[]); 2];
    let states = [state.clone(), state.clone()];
    let untouched = Evaluation {
        gradient: vec![1.0, 2.0],
        contacts: 42,
        ..Evaluation::default()
    };
    let mut out = [untouched.clone(), untouched.clone()];
    block_on(async {
        potential.begin_step(&starts, &[true, false]).await.unwrap();
        potential
            .evaluate(&states, &[true, false], &mut out)
            .await
            .unwrap();
    });
    assert_eq!(
        (&out[1].gradient, out[1].contacts),
        (&untouched.gradient, 42)
    );
    assert_ne!(out[0].gradient, untouched.gradient);
    // It has begun no step, so it cannot be evaluated.
    let error = block_on(potential.evaluate(&states, &[false, true], &mut out)).unwrap_err();
    assert!(error.to_string().contains("begin_step"), "{error}");
}

#[test]
fn a_step_from_the_drawn_pose_has_the_bits_of_one_from_scratch() {
    let avatar = avatar();
    let [previous, current, state] = &triples(&avatar)[0];
    let colliders = [floor(-0.01)];
    let evaluate = |drawn: &[&State]| {
        let mut potential = CpuPotential::new(avatar.clone(), 1).unwrap();
        for state in drawn {
            block_on(potential.pose_skin(std::slice::from_ref(state), &[], &[])).unwrap();
        }
        let mut out = [Evaluation::default()];
        block_on(potential.begin_step(&[start(previous, current, &colliders)], &[true])).unwrap();
        block_on(potential.evaluate(std::slice::from_ref(state), &[true], &mut out)).unwrap();
        let [evaluation] = out;
        (evaluation, 0.0, Vec::new())
    };
    let scratch = evaluate(&[]);
    assert_same_bits(&evaluate(&[current]), &scratch);
    assert_same_bits(&evaluate(&[current, state]), &scratch);
}
