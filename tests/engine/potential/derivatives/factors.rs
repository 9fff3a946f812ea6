//! Factors on the tissue: each on its own term, and the derivatives stay those of the energy.

use super::case::{Case, cases, factors};
use super::{STEP, difference, evaluate, largest, unit};
use pollster::block_on;
use supple::internal::cpu::HessianForm;
use supple::material::{DEFAULT_BOUNCE, damping_ratio};
use supple::potential::{Evaluation, Potential, TissueFactors};

/// Everything at once, with friction that neither holds nor only slips.
fn case(factors: TissueFactors) -> Case {
    Case {
        factors,
        slip_speed: 0.5,
        ..cases().pop().unwrap()
    }
}

#[test]
fn each_factor_multiplies_its_own_term() {
    let [_, _, state] = case(TissueFactors::default()).states();
    let energies = |factors| {
        let mut case = case(factors);
        for local in &mut case.avatar.tissue {
            local.muscle = 0.25;
        }
        // Contact that follows the tissue does so under its factor too.
        for collider in &mut case.colliders {
            collider.stiffness = Some(1e6);
        }
        evaluate(&mut case.reference(), &state).energies
    };
    let (plain, scaled) = (energies(TissueFactors::default()), energies(factors()));
    let f = factors();
    let tense = 1.0 + 7.0 * f.tension * 0.25;
    for (name, plain, scaled, factor) in [
        ("inertia", plain.inertia, scaled.inertia, 1.0),
        ("gravity", plain.gravity, scaled.gravity, f.gravity),
        // All of the tissue is a quarter muscle here: 1 + 7 τ/4 times as stiff, the damping time its root shorter.
        (
            "elastic",
            plain.elastic,
            scaled.elastic,
            f.stiffness * tense,
        ),
        (
            "damping",
            plain.damping,
            scaled.damping,
            f.stiffness * f.damping * tense.sqrt(),
        ),
        ("contact", plain.contact, scaled.contact, 1.0),
        ("friction", plain.friction, scaled.friction, f.friction),
    ] {
        let error = (scaled - factor * plain).abs();
        assert!(
            plain != 0.0 && error < 1e-12 * plain.abs(),
            "{name}: {scaled}, {plain}"
        );
    }
}

/// Tension stiffens muscle, each point by its own share, and leaves fat and the damping ratio as they are.
#[test]
fn tension_is_felt_by_the_share_of_muscle() {
    let [_, _, state] = case(TissueFactors::default()).states();
    let energies = |tension: f64, muscle: fn(usize) -> f64| {
        let mut factors = TissueFactors::default();
        factors.tension = tension;
        let mut case = case(factors);
        for (i, local) in case.avatar.tissue.iter_mut().enumerate() {
            local.muscle = muscle(i);
        }
        evaluate(&mut case.reference(), &state).energies
    };
    let relaxed = energies(0.0, |_| 1.0);
    assert_eq!(energies(1.0, |_| 0.0), relaxed);
    let tense = energies(1.0, |_| 1.0);
    assert!((tense.elastic - 8.0 * relaxed.elastic).abs() < 1e-12 * tense.elastic.abs());
    let ratio = tense.damping / relaxed.damping;
    assert!((ratio - 8f64.sqrt()).abs() < 1e-12, "{ratio}");
    // Two halves of the points, each tense alone.
    let [even, odd] = [
        energies(1.0, |i| f64::from(i % 2 == 0)),
        energies(1.0, |i| f64::from(i % 2 == 1)),
    ];
    let sum = even.elastic + odd.elastic - relaxed.elastic;
    assert!((sum - tense.elastic).abs() < 1e-12 * tense.elastic.abs());
    assert!((even.elastic - odd.elastic).abs() > 1e-3 * tense.elastic.abs());
}

#[test]
fn bounce_sets_the_damping_of_tissue_that_was_baked_with_the_default() {
    let damping = |bounce| TissueFactors::with_bounce(bounce).unwrap().damping;
    assert_eq!(damping(DEFAULT_BOUNCE), 1.0);
    for (bounce, ratio) in [(0.0, 1.0), (0.25, 0.4217), (0.5, 0.1778), (1.0, 0.0316)] {
        let zeta = damping(bounce) * damping_ratio(DEFAULT_BOUNCE);
        assert!((zeta - ratio).abs() < 1e-4, "{bounce}: {zeta}");
    }
    let mut factors = TissueFactors::default();
    for bounce in [-1e-9, 1.1, f64::NAN, f64::INFINITY] {
        let error = factors.set_bounce(bounce).unwrap_err().to_string();
        assert!(error.contains("factors.bounce"), "{error}");
    }
    assert_eq!(factors, TissueFactors::default());
}

#[test]
fn with_factors_gradient_and_hessian_are_those_of_the_energy() {
    let case = case(factors());
    let mut potential = case.reference();
    let [_, current, state] = case.states();
    let evaluation = evaluate(&mut potential, &state);
    let total = difference(&mut potential, &current, &state);
    assert!((evaluation.energies.total() - total).abs() < 1e-10 * total.abs());
    let dofs = evaluation.gradient.len();
    let exact = potential
        .dense_hessian(0, &state, HessianForm::Exact)
        .unwrap();
    let scale = largest(evaluation.gradient.iter().copied());
    let hessian_scale = largest(exact.iter().flatten().copied());
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for k in 0..dofs {
        let e = unit(dofs, k);
        let [ahead, behind]: [Evaluation; 2] =
            [STEP, -STEP].map(|s| evaluate(&mut potential, &state.moved(&e, s)));
        let slope = (ahead.energies.total() - behind.energies.total()) / (2.0 * STEP);
        let error = (evaluation.gradient[k] - slope).abs();
        assert!(
            error < 2e-6 * scale,
            "{k}: {} against {slope}",
            evaluation.gradient[k]
        );
        let pairs = ahead.gradient.iter().zip(&behind.gradient);
        columns.push(pairs.map(|(a, b)| (a - b) / (2.0 * STEP)).collect());
    }
    for i in 0..dofs {
        for k in 0..=i {
            let expected = 0.5 * (columns[k][i] + columns[i][k]);
            let error = (exact[i][k] - expected).abs();
            assert!(
                error < 1e-5 * hessian_scale,
                "({i}, {k}): {} against {expected}",
                exact[i][k]
            );
        }
    }
}

/// A factor's name, itself, and values that it cannot have.
type Refused = (
    &'static str,
    fn(&mut TissueFactors) -> &mut f64,
    &'static [f64],
);

#[test]
fn unusable_factors_are_refused_by_name() {
    let case = case(TissueFactors::default());
    let [previous, current, _] = &case.states();
    let mut potential = case.reference();
    let set: [Refused; 5] = [
        (
            "stiffness",
            |f| &mut f.stiffness,
            &[0.0, -1.0, f64::NAN, f64::INFINITY],
        ),
        (
            "damping",
            |f| &mut f.damping,
            &[-1e-9, f64::NAN, f64::INFINITY],
        ),
        (
            "gravity",
            |f| &mut f.gravity,
            &[-1.0, f64::NAN, f64::INFINITY],
        ),
        (
            "friction",
            |f| &mut f.friction,
            &[-1.0, f64::NAN, f64::INFINITY],
        ),
        (
            "tension",
            |f| &mut f.tension,
            &[-1e-9, 1.1, f64::NAN, f64::INFINITY],
        ),
    ];
    for (name, field, values) in set {
        for &value in values {
            let mut factors = TissueFactors::default();
            *field(&mut factors) = value;
            let mut start = case.start(previous, current);
            start.factors = factors;
            let error = block_on(potential.begin_step(&[start], &[true])).unwrap_err();
            let error = error.to_string();
            assert!(
                error.contains(&format!("factors.{name}")),
                "{value}: {error}"
            );
        }
    }
    let mut none = TissueFactors::default();
    (none.damping, none.gravity, none.friction) = (0.0, 0.0, 0.0);
    assert!(none.validate().is_ok());
}
