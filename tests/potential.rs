//! The incremental potential of the f64 evaluation against differences of itself, on a random avatar far
//! from rest, moving, with every collider shape in touch: each term alone, and all of them.

use supple::collider::{Collider, Shape};
use supple::glam::{DMat3, DVec3};
use supple::material::{Material, StableNeoHookean};
use supple::math::{Random, Rows};
use supple::model::{Avatar, BasisEntry, Frame, PoseBlend, State};
use supple::potential::{Evaluation, Potential, StepStart, Trial};
use supple::reference::{GeneralBasis, HessianForm, Reference};
use supple::sample::{random_avatar, random_state};

use pollster::block_on;
use std::sync::Arc;

/// What a case is made of.
struct Case {
    name: &'static str,
    avatar: Avatar,
    time_step: f64,
    tissue_gravity: DVec3,
    colliders: Vec<Collider>,
    slip_speed: f64,
}

fn soft(youngs_modulus: f64) -> Material {
    Material::StableNeoHookean(StableNeoHookean {
        youngs_modulus,
        poissons_ratio: 0.4,
    })
}

/// Every shape, turned and placed so that part of the skin is in it.
fn colliders(random: &mut Random) -> Vec<Collider> {
    let place = |shape| {
        let frame = Frame {
            rotation: random.rotation(1.0),
            position: DVec3::new(1.0, 2.0, 3.0) + random.vector(0.04),
        };
        Collider {
            stiffness: 1e6,
            margin: 4e-3,
            ..Collider::new(shape, frame)
        }
    };
    Shape::examples().into_iter().map(place).collect()
}

/// The same, rough and on the move.
fn rough(random: &mut Random) -> Vec<Collider> {
    let mut colliders = colliders(random);
    for collider in &mut colliders {
        let (shift, turn) = (random.vector(1e-5), random.vector(3e-4));
        collider.previous = collider.frame.moved(shift, turn);
        collider.friction = random.uniform(0.2, 1.0);
    }
    colliders
}

/// The same, every other one fixed to the frame `carrier`, which stands at the avatar's place.
fn carried(random: &mut Random, carrier: u32) -> Vec<Collider> {
    let mut colliders = rough(random);
    for collider in colliders.iter_mut().step_by(2) {
        collider.carrier = Some(carrier);
        collider.frame.position -= DVec3::new(1.0, 2.0, 3.0);
    }
    colliders
}

/// `avatar` with a frame more: a free body without tissue.
fn with_body(mut avatar: Avatar) -> Avatar {
    avatar.skeleton.names.push("body".into());
    avatar.skeleton.parents.push(None);
    avatar.skeleton.joints.push(DVec3::new(0.01, -0.02, 0.03));
    avatar.bone_masses.push(avatar.bone_masses[0]);
    avatar.cubature.pose_blend = PoseBlend::default();
    avatar.skin.pose_blend = PoseBlend::default();
    avatar.validate().unwrap();
    avatar
}

fn cases() -> Vec<Case> {
    let random = &mut Random::new(11);
    let avatar = |density: f64, material: Material, damping_time: f64| Avatar {
        density,
        material,
        damping_time,
        ..random_avatar(3, 3, 6, 12, 60)
    };
    let gravity = DVec3::new(1.0, -9.0, 2.0);
    let case = |name, avatar, time_step, tissue_gravity, colliders| Case {
        name,
        avatar,
        time_step,
        tissue_gravity,
        colliders,
        slip_speed: 1e-3,
    };
    // A term is alone where the others' factors are made negligible.
    let none = 1e-15;
    vec![
        case(
            "inertia",
            avatar(1e3, soft(none), 0.0),
            0.01,
            DVec3::ZERO,
            vec![],
        ),
        case(
            "gravity",
            avatar(1e3, soft(none), 0.0),
            1e9,
            gravity,
            vec![],
        ),
        case(
            "elastic",
            avatar(none, soft(3e4), 0.0),
            0.01,
            DVec3::ZERO,
            vec![],
        ),
        case(
            "damping",
            avatar(none, soft(none), 1e20),
            0.01,
            DVec3::ZERO,
            vec![],
        ),
        case(
            "contact",
            avatar(none, soft(none), 0.0),
            0.01,
            DVec3::ZERO,
            colliders(random),
        ),
        case(
            "friction",
            avatar(none, soft(none), 0.0),
            0.01,
            DVec3::ZERO,
            rough(random),
        ),
        Case {
            slip_speed: 0.5,
            ..case(
                "friction that holds",
                avatar(none, soft(none), 0.0),
                0.01,
                DVec3::ZERO,
                rough(random),
            )
        },
        case(
            "carried",
            with_body(avatar(none, soft(none), 0.0)),
            0.01,
            DVec3::ZERO,
            carried(random, 3),
        ),
        case(
            "all",
            with_body(avatar(1e3, soft(3e4), 0.02)),
            0.01,
            gravity,
            // No crease and no vertex on the brink within a step of the differences.
            carried(&mut Random::new(12), 3),
        ),
    ]
}

impl Case {
    /// qⁿ⁻¹, qⁿ, and a state away from both, somewhere far from the world's origin.
    fn states(&self) -> [State; 3] {
        let random = &mut Random::new(21);
        let mut base = random_state(22, &self.avatar, 0.8, 0.004);
        base.frames
            .iter_mut()
            .for_each(|f| f.position += DVec3::new(1.0, 2.0, 3.0));
        let mut step = |size: f64| -> Vec<f64> {
            (0..3 * base.space().blocks())
                .map(|k| {
                    let frames = 2 * self.avatar.skeleton.len();
                    let rotation = k / 3 < frames && k / 3 % 2 == 1;
                    random.uniform(-1.0, 1.0) * size * if rotation { 20.0 } else { 1.0 }
                })
                .collect()
        };
        let (first, second) = (step(1e-3), step(2e-3));
        [
            base.clone(),
            base.moved(&first, 1.0),
            base.moved(&second, 1.0),
        ]
    }

    fn begun<B: supple::reference::Basis>(&self, mut potential: Reference<B>) -> Reference<B> {
        let [previous, current, _] = &self.states();
        let start = StepStart {
            time_step: self.time_step,
            previous,
            current,
            colliders: &self.colliders,
            tissue_gravity: self.tissue_gravity,
            slip_speed: self.slip_speed,
            geometric_contact: true,
        };
        let count = potential.instances();
        block_on(potential.begin_step(&vec![start; count], &vec![true; count])).unwrap();
        potential
    }

    fn reference(&self) -> Reference {
        self.begun(Reference::new(Arc::new(self.avatar.clone()), 1, 1000).unwrap())
    }
}

fn evaluate<B: supple::reference::Basis>(
    potential: &mut Reference<B>,
    state: &State,
) -> Evaluation {
    let mut out = [Evaluation::default()];
    block_on(potential.evaluate(std::slice::from_ref(state), &[true], &mut out)).unwrap();
    let [evaluation] = out;
    evaluation
}

fn difference(potential: &mut Reference, base: &State, state: &State) -> f64 {
    let trial = Trial {
        instance: 0,
        base,
        state,
    };
    let mut out = [0.0];
    block_on(potential.energy_differences(&[trial], &mut out)).unwrap();
    out[0]
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

#[test]
fn a_general_basis_gives_what_the_scalar_one_gives() {
    let case = cases().pop().unwrap();
    let general = |rows: &Rows<BasisEntry>| rows.map(|entry| GeneralBasis::from(entry));
    let (cubature, skin) = (
        general(&case.avatar.cubature.basis),
        general(&case.avatar.skin.basis),
    );
    let avatar = Arc::new(case.avatar.clone());
    let other = Reference::with_basis(avatar, &cubature, &skin, 1, 1000).unwrap();
    let mut other = case.begun(other);
    let mut scalar = case.reference();
    let [.., state] = case.states();
    let (a, b) = (evaluate(&mut scalar, &state), evaluate(&mut other, &state));
    let close = |x: &[f64], y: &[f64]| {
        let scale = largest(x.iter().copied());
        x.len() == y.len() && x.iter().zip(y).all(|(x, y)| (x - y).abs() < 1e-12 * scale)
    };
    assert!(close(&a.gradient, &b.gradient));
    assert!(close(a.hessian.as_flattened(), b.hessian.as_flattened()));
    assert!(close(&[a.energies.total()], &[b.energies.total()]));
}

#[test]
fn a_basis_that_is_not_scalar_has_true_derivatives_too() {
    let case = cases().pop().unwrap();
    let random = &mut Random::new(31);
    let mut mixed = |rows: &Rows<BasisEntry>| {
        rows.map(|entry| GeneralBasis {
            handle: entry.handle,
            value: random.matrix(0.1),
            gradient: [random.matrix(5.0), random.matrix(5.0), random.matrix(5.0)],
        })
    };
    let (cubature, skin) = (
        mixed(&case.avatar.cubature.basis),
        mixed(&case.avatar.skin.basis),
    );
    let avatar = Arc::new(case.avatar.clone());
    let mut potential =
        case.begun(Reference::with_basis(avatar, &cubature, &skin, 1, 1000).unwrap());
    let [.., state] = case.states();
    let evaluation = evaluate(&mut potential, &state);
    let dofs = evaluation.gradient.len();
    let scale = largest(evaluation.gradient.iter().copied());
    for k in 0..dofs {
        let e = unit(dofs, k);
        let ahead = evaluate(&mut potential, &state.moved(&e, STEP)).energies;
        let behind = evaluate(&mut potential, &state.moved(&e, -STEP)).energies;
        let expected = (ahead.total() - behind.total()) / (2.0 * STEP);
        assert!(
            (evaluation.gradient[k] - expected).abs() < 1e-5 * scale,
            "{k}"
        );
    }
    let solver = potential
        .dense_hessian(0, &state, HessianForm::Solver)
        .unwrap();
    let scale = largest(solver.iter().flatten().copied());
    for ((row, column), block) in potential.pattern().blocks().zip(&evaluation.hessian) {
        let dense = DMat3::from_cols_array(&std::array::from_fn(|m| {
            solver[3 * row + m % 3][3 * column + m / 3]
        }));
        let error = (DMat3::from_cols_array(block) - dense).to_cols_array();
        assert!(largest(error) < 1e-12 * scale);
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
        case.avatar.damping_time = 0.0;
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
