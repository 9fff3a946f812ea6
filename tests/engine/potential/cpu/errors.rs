//! Typed errors of the f64 evaluation.

use super::batches::triples;
use super::invariance::posed;
use super::{avatar, floor, start};
use pollster::block_on;
use std::sync::Arc;
use supple::Error;
use supple::collider::Collider;
use supple::glam::{DVec2, DVec3};
use supple::model::SkinWeight;
use supple::potential::{CpuPotential, Evaluation, Potential, StepStart};

#[test]
fn contact_reports_its_force() {
    let avatar = avatar();
    let [previous, current, state] = &triples(&avatar)[0];
    let colliders = [floor(-0.01)];
    let mut potential = CpuPotential::new(avatar.clone(), 1).unwrap();
    let mut out = [Evaluation::default()];
    block_on(potential.begin_step(&[start(previous, current, &colliders)], &[true])).unwrap();
    block_on(potential.evaluate(std::slice::from_ref(state), &[true], &mut out)).unwrap();
    let [evaluation] = out;
    assert!(evaluation.contacts > 10 && evaluation.contacts < avatar.skin.len());

    // Σ over vertices of k a (d̂ − z): the floor pushes up.
    let mut expected = 0.0;
    for v in 0..avatar.skin.len() {
        let z = posed(&avatar, v, &current.frames, state).z;
        let k = avatar.contact_stiffness[v].min(1e8);
        expected += k * avatar.skin.measure[v] * (1e-3 - (z + 0.01)).max(0.0);
    }
    assert!((evaluation.contact_force.z - expected).abs() < 1e-9 * expected);
    assert_eq!(evaluation.contact_force.truncate(), DVec2::ZERO);
}

#[test]
fn unusable_input_is_refused_by_name() {
    let avatar = avatar();
    let rest = avatar.rest_state();
    let mut potential = CpuPotential::new(avatar.clone(), 1).unwrap();
    let good = start(&rest, &rest, &[]);
    let mut refuse = |start: StepStart<'_>, name: &str| {
        let error = block_on(potential.begin_step(&[start], &[true])).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
    };
    refuse(
        StepStart {
            time_step: 0.0,
            ..good
        },
        "time_step",
    );
    refuse(
        StepStart {
            tissue_gravity: DVec3::NAN,
            ..good
        },
        "tissue_gravity",
    );
    let nowhere = [Collider {
        margin: f64::NAN,
        ..floor(0.0)
    }];
    refuse(
        StepStart {
            colliders: &nowhere,
            ..good
        },
        "colliders[0].margin",
    );
    let mut broken = rest.clone();
    broken.handles[2].y = f64::INFINITY;
    refuse(
        StepStart {
            current: &broken,
            ..good
        },
        "state is not finite",
    );
    let mut short = rest.clone();
    short.handles.pop();
    refuse(
        StepStart {
            current: &short,
            ..good
        },
        "state",
    );
    let error = block_on(potential.begin_step(&[good, good], &[true])).unwrap_err();
    assert!(error.to_string().contains("starts"), "{error}");

    let mut twice = (*avatar).clone();
    let half = |w: &SkinWeight| SkinWeight { weight: 0.5, ..*w };
    twice.cubature.skinning = twice
        .cubature
        .skinning
        .iter()
        .map(|row| [half(&row[0]), half(&row[0])])
        .collect();
    let error = CpuPotential::new(Arc::new(twice), 1).err().unwrap();
    assert!(error.to_string().contains("twice"), "{error}");
}

#[test]
fn a_state_too_large_to_have_an_energy_is_an_error() {
    let avatar = avatar();
    let rest = avatar.rest_state();
    let mut potential = CpuPotential::new(avatar.clone(), 1).unwrap();
    block_on(potential.begin_step(&[start(&rest, &rest, &[])], &[true])).unwrap();
    let mut huge = rest.clone();
    huge.handles
        .iter_mut()
        .for_each(|h| *h = DVec3::splat(1e200));
    let mut out = [Evaluation::default()];
    let error = block_on(potential.evaluate(&[huge], &[true], &mut out)).unwrap_err();
    assert!(matches!(error, Error::NotFinite { .. }), "{error}");
}
