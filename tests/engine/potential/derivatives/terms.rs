//! Value, gradient and Hessian of contact and friction, and of every case as a whole.

use super::case::{carried, cases, soft};
use super::{STEP, difference, evaluate, largest, unit};
use supple::collider::Shape;
use supple::glam::DVec3;
use supple::internal::cpu::HessianForm;
use supple::internal::math::Random;
use supple::model::State;
use supple::potential::Potential;

#[test]
fn evaluated_energy_is_the_difference_from_the_start_of_the_step() {
    for case in cases() {
        let mut potential = case.reference();
        let [_, current, state] = case.states();
        let evaluation = evaluate(&mut potential, &state);
        let total = evaluation.energies.total();
        assert!(total != 0.0, "{}", case.name);
        let expected = difference(&mut potential, &current, &state);
        assert!(
            (total - expected).abs() < 1e-10 * total.abs(),
            "{}: {total}",
            case.name
        );
        // Differences add up along any path.
        let middle = current.moved(&current.step_to(&state), 0.3);
        let sum = difference(&mut potential, &current, &middle)
            + difference(&mut potential, &middle, &state);
        assert!(
            (total - sum).abs() < 1e-10 * total.abs(),
            "{}: {sum}",
            case.name
        );
        if case.name == "contact" || case.name == "all" {
            assert!(evaluation.contacts > 20, "{} contacts", evaluation.contacts);
        }
    }
}

/// What friction adds to contact: the difference of a run with it and one without.
#[test]
fn friction_alone_has_true_derivatives() {
    for slip_speed in [1e-3, 0.5] {
        let random = &mut Random::new(41);
        let mut case = cases().pop().unwrap();
        case.colliders = carried(random, 3);
        case.slip_speed = slip_speed;
        let mut with = case.reference();
        case.colliders.iter_mut().for_each(|c| c.friction = 0.0);
        let mut without = case.reference();
        let [_, current, state] = case.states();

        let smooth = evaluate(&mut without, &state);
        assert_eq!(smooth.energies.friction, 0.0);
        let mut alone = |state: &State| {
            let (a, b) = (evaluate(&mut with, state), evaluate(&mut without, state));
            let gradient = a.gradient.iter().zip(&b.gradient);
            let gradient: Vec<f64> = gradient.map(|(a, b)| a - b).collect();
            (a.energies.friction, gradient)
        };
        let (energy, gradient) = alone(&state);
        assert!(energy > 0.0 && alone(&current).0 == 0.0);
        let dofs = gradient.len();
        let scale = largest(gradient.iter().copied());
        assert!(scale > 1e-3, "{scale}");
        let mut columns = Vec::new();
        for k in 0..dofs {
            let e = unit(dofs, k);
            let (ahead, behind) = (
                alone(&state.moved(&e, STEP)),
                alone(&state.moved(&e, -STEP)),
            );
            let expected = (ahead.0 - behind.0) / (2.0 * STEP);
            assert!(
                (gradient[k] - expected).abs() < 2e-6 * scale,
                "{k}: {} against {expected}",
                gradient[k]
            );
            let pairs = ahead.1.iter().zip(&behind.1);
            let column: Vec<f64> = pairs.map(|(a, b)| (a - b) / (2.0 * STEP)).collect();
            columns.push(column);
        }
        let hessian = |form| {
            let [a, b] = [&with, &without].map(|p| p.dense_hessian(0, &state, form).unwrap());
            faer::Mat::from_fn(dofs, dofs, |i, k| a[i][k] - b[i][k])
        };
        let (exact, solver) = (hessian(HessianForm::Exact), hessian(HessianForm::Solver));
        let scale = exact.norm_max();
        for i in 0..dofs {
            for k in 0..=i {
                let expected = 0.5 * (columns[k][i] + columns[i][k]);
                let error = (exact[(i, k)] - expected).abs();
                assert!(error < 1e-5 * scale, "({i}, {k}): {expected}");
            }
        }
        let eigenvalues = solver.self_adjoint_eigenvalues(faer::Side::Lower).unwrap();
        assert!(eigenvalues[0] > -1e-11 * scale && eigenvalues[dofs - 1] > 1e-3 * scale);
    }
}

/// What contact and friction lack to all their second derivatives are the geometric terms and −k a δ ∇²d: nothing for
/// a plane, and not above 0 for what is convex.
#[test]
fn geometric_terms_complete_the_hessian_of_contact() {
    let shapes = [
        Shape::HalfSpace,
        Shape::Sphere { radius: 0.02 },
        Shape::Capsule {
            radius: 0.02,
            half_length: 0.02,
        },
    ];
    for (k, shape) in shapes.into_iter().enumerate() {
        let flat = k == 0;
        let mut case = cases().pop().unwrap();
        case.avatar.density = 1e-15;
        case.avatar.set_damping_time(0.0);
        case.avatar.material = soft(1e-15);
        case.tissue_gravity = DVec3::ZERO;
        case.colliders = carried(&mut Random::new(51), 3);
        for collider in &mut case.colliders {
            collider.shape = shape.clone();
        }
        let [_, _, state] = case.states();
        let mut potential = case.reference();
        let evaluation = evaluate(&mut potential, &state);
        assert!(
            evaluation.contacts > 10,
            "{shape:?}: {}",
            evaluation.contacts
        );
        let exact = potential
            .dense_hessian(0, &state, HessianForm::Exact)
            .unwrap();
        let scale = largest(exact.iter().flatten().copied());
        let geometric = largest(evaluation.geometric.iter().flatten().copied());
        assert!(
            geometric > 1e-5 * scale,
            "{shape:?}: {geometric} of {scale}"
        );
        let dofs = exact.len();
        let mut missing = faer::Mat::<f64>::zeros(dofs, dofs);
        let blocks = evaluation.hessian.iter().zip(&evaluation.geometric);
        for ((row, column), (a, b)) in potential.pattern().blocks().zip(blocks) {
            for k in 0..9 {
                let (r, c) = (3 * row + k % 3, 3 * column + k / 3);
                missing[(r, c)] = exact[r][c] - a[k] - b[k];
                missing[(c, r)] = missing[(r, c)];
            }
        }
        let eigenvalues = missing.self_adjoint_eigenvalues(faer::Side::Lower).unwrap();
        let (least, most) = (eigenvalues[0], eigenvalues[dofs - 1]);
        assert!(most < 1e-11 * scale, "{shape:?}: {most} of {scale}");
        assert!(
            (least > -1e-11 * scale) == flat,
            "{shape:?}: {least} of {scale}"
        );
    }
}
