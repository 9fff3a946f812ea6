//! The f64 evaluation as a whole: batches, determinism, errors, the drawn skin, the smallest det F.

use pollster::block_on;
use std::sync::Arc;
use supple::Error;
use supple::collider::{Collider, Shape};
use supple::glam::{DMat3, DVec2, DVec3};
use supple::math::Random;
use supple::model::{Avatar, Frame, SkinWeight, State, Surface, pose_feature};
use supple::potential::{Evaluation, Potential, StepStart, Trial};
use supple::reference::{Reference, min_det_f};
use supple::sample::{random_avatar, random_state};

fn avatar() -> Arc<Avatar> {
    Arc::new(random_avatar(7, 4, 12, 90, 300))
}

fn floor(height: f64) -> Collider {
    let frame = Frame {
        rotation: DMat3::IDENTITY,
        position: DVec3::Z * height,
    };
    Collider {
        margin: 1e-3,
        ..Collider::new(Shape::HalfSpace, frame)
    }
}

fn start<'a>(previous: &'a State, current: &'a State, colliders: &'a [Collider]) -> StepStart<'a> {
    StepStart {
        time_step: 0.01,
        previous,
        current,
        colliders,
        tissue_gravity: DVec3::ZERO,
        slip_speed: 1e-3,
        geometric_contact: false,
    }
}

/// Two steps' start states and one to evaluate, for each of three instances.
fn triples(avatar: &Avatar) -> Vec<[State; 3]> {
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
    let mut potential = Reference::new(avatar.clone(), triples.len(), 2000).unwrap();
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
    let mut differences = vec![0.0; triples.len()];
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
        potential.pose_skin(&states).await.unwrap();
    });
    let mut skin = |k| {
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        block_on(potential.read_skin(k, &mut positions, &mut normals)).unwrap();
        positions.extend(normals);
        positions
    };
    let results = out.into_iter().zip(differences).enumerate();
    results
        .map(|(k, (evaluation, difference))| (evaluation, difference, skin(k)))
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
    let mut potential = Reference::new(avatar.clone(), 2, 2000).unwrap();
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
fn contact_reports_its_force_and_refuses_to_overflow() {
    let avatar = avatar();
    let [previous, current, state] = &triples(&avatar)[0];
    let colliders = [floor(-0.01)];
    let evaluate = |capacity| {
        let mut potential = Reference::new(avatar.clone(), 1, capacity)?;
        let mut out = [Evaluation::default()];
        block_on(potential.begin_step(&[start(previous, current, &colliders)], &[true]))?;
        block_on(potential.evaluate(std::slice::from_ref(state), &[true], &mut out))?;
        let [evaluation] = out;
        Ok::<_, Error>(evaluation)
    };
    let evaluation = evaluate(2000).unwrap();
    assert!(evaluation.contacts > 10 && evaluation.contacts < avatar.skin.len());
    // Exactly enough room is enough; one less is an error that says so.
    let exact = evaluate(evaluation.contacts).unwrap();
    assert_eq!(exact.contacts, evaluation.contacts);
    let error = evaluate(evaluation.contacts - 1).unwrap_err().to_string();
    assert!(
        error.contains("contact_capacity") && error.contains("room"),
        "{error}"
    );

    // Σ over vertices of k a (d̂ − z): the floor pushes up.
    let mut expected = 0.0;
    for v in 0..avatar.skin.len() {
        let z = posed(&avatar, v, &current.frames, state).z;
        expected += 1e8 * avatar.skin.measure[v] * (1e-3 - (z + 0.01)).max(0.0);
    }
    assert!((evaluation.contact_force.z - expected).abs() < 1e-9 * expected);
    assert_eq!(evaluation.contact_force.truncate(), DVec2::ZERO);
}

/// Skin vertex `v` with x̄ of the pose `frames`, written out.
fn posed(avatar: &Avatar, v: usize, frames: &[Frame], state: &State) -> DVec3 {
    let skin = &avatar.skin;
    let mut unposed = skin.position[v];
    for (k, value) in pose_feature(&avatar.skeleton.parents, frames)
        .iter()
        .enumerate()
    {
        let column = skin.pose_blend.columns[k * skin.len() + v];
        unposed += *value * DVec3::from_array(column.map(f64::from));
    }
    for entry in skin.basis.row(v) {
        unposed += entry.value * state.handles[entry.handle as usize];
    }
    let weights = skin.skinning.row(v).iter();
    weights
        .map(|w| {
            let j = w.bone as usize;
            w.weight * state.frames[j].transform(unposed - avatar.skeleton.joints[j])
        })
        .sum()
}

#[test]
fn the_drawn_skin_is_the_parametric_model_moved_by_the_handles() {
    let avatar = avatar();
    let state = random_state(3, &avatar, 1.0, 0.01);
    let mut potential = Reference::new(avatar.clone(), 1, 1).unwrap();
    block_on(potential.pose_skin(std::slice::from_ref(&state))).unwrap();
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    block_on(potential.read_skin(0, &mut positions, &mut normals)).unwrap();
    for (v, &position) in positions.iter().enumerate() {
        assert!(position.distance(posed(&avatar, v, &state.frames, &state)) < 1e-15);
    }
    let surface = Surface {
        positions,
        triangles: avatar.triangles.clone(),
    };
    for (normal, expected) in normals.iter().zip(surface.vertex_normals()) {
        assert!(normal.distance(expected) < 1e-12);
    }
}

#[test]
fn a_step_from_the_drawn_pose_has_the_bits_of_one_from_scratch() {
    let avatar = avatar();
    let [previous, current, state] = &triples(&avatar)[0];
    let colliders = [floor(-0.01)];
    let evaluate = |drawn: &[&State]| {
        let mut potential = Reference::new(avatar.clone(), 1, 2000).unwrap();
        for state in drawn {
            block_on(potential.pose_skin(std::slice::from_ref(state))).unwrap();
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

#[test]
fn a_scene_moved_rigidly_has_the_same_energy_and_a_turned_gradient() {
    let avatar = avatar();
    let [previous, current, state] = triples(&avatar)[0].clone();
    let random = &mut Random::new(9);
    let (turn, shift) = (random.rotation(2.0), DVec3::new(3.0, -5.0, 4.0));
    let place = |frame: Frame| Frame {
        rotation: turn * frame.rotation,
        position: turn * frame.position + shift,
    };
    let moved = |state: &State| State {
        frames: state.frames.iter().map(|f| place(*f)).collect(),
        handles: state.handles.clone(),
    };
    let evaluate = |states: [&State; 3], collider: Collider, tissue_gravity| {
        let mut potential = Reference::new(avatar.clone(), 1, 2000).unwrap();
        let colliders = [collider];
        let begin = StepStart {
            tissue_gravity,
            ..start(states[0], states[1], &colliders)
        };
        let mut out = [Evaluation::default()];
        block_on(potential.begin_step(&[begin], &[true])).unwrap();
        block_on(potential.evaluate(&[states[2].clone()], &[true], &mut out)).unwrap();
        let [evaluation] = out;
        evaluation
    };
    let gravity = DVec3::new(0.0, 0.0, -9.81);
    let here = evaluate([&previous, &current, &state], floor(-0.02), gravity);
    let there = evaluate(
        [&moved(&previous), &moved(&current), &moved(&state)],
        Collider {
            frame: place(floor(-0.02).frame),
            ..floor(-0.02)
        },
        turn * gravity,
    );
    let scale = here.energies.elastic + here.energies.contact.abs();
    assert!((here.energies.total() - there.energies.total()).abs() < 1e-10 * scale);
    let size = here.gradient.iter().fold(0.0, |a, g| f64::max(a, g.abs()));
    let frames = 2 * avatar.skeleton.len();
    for (block, (a, b)) in here
        .gradient
        .chunks(3)
        .zip(there.gradient.chunks(3))
        .enumerate()
    {
        let a = DVec3::from_slice(a);
        let expected = if block < frames { turn * a } else { a };
        assert!(
            DVec3::from_slice(b).distance(expected) < 1e-9 * size,
            "{block}"
        );
    }
}

#[test]
fn unusable_input_is_refused_by_name() {
    let avatar = avatar();
    let rest = avatar.rest_state();
    let mut potential = Reference::new(avatar.clone(), 1, 10).unwrap();
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
        "collider.margin",
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
    let error = Reference::new(Arc::new(twice), 1, 10).err().unwrap();
    assert!(error.to_string().contains("twice"), "{error}");
}

#[test]
fn a_state_too_large_to_have_an_energy_is_an_error() {
    let avatar = avatar();
    let rest = avatar.rest_state();
    let mut potential = Reference::new(avatar.clone(), 1, 10).unwrap();
    block_on(potential.begin_step(&[start(&rest, &rest, &[])], &[true])).unwrap();
    let mut huge = rest.clone();
    huge.handles
        .iter_mut()
        .for_each(|h| *h = DVec3::splat(1e200));
    let mut out = [Evaluation::default()];
    let error = block_on(potential.evaluate(&[huge], &[true], &mut out)).unwrap_err();
    assert!(matches!(error, Error::NotFinite { .. }), "{error}");
}

#[test]
fn min_det_f_sees_the_worst_tet() {
    let avatar = avatar();
    let mut state = avatar.rest_state();
    assert!((min_det_f(&avatar.layer, &state) - 1.0).abs() < 1e-12);
    // Without a handle on it, every node of the cube follows handle 0 alone, by half.
    let mut layer = avatar.layer.clone();
    layer.basis = layer
        .bone_of_node
        .iter()
        .map(|bone| bone.is_none().then_some((0, 0.5)))
        .collect();
    // The upper face (0.1 m above the fixed one) moves down by half of 0.16 m: det F = 1 − 0.8.
    state.handles[0] = DVec3::new(0.05, -0.02, -0.16);
    assert!((min_det_f(&layer, &state) - 0.2).abs() < 1e-12);
    // One node alone: the worst tet is worse than the mean.
    layer.basis = (0..8).map(|n| (n == 7).then_some((0, 1.0))).collect();
    state.handles[0] = DVec3::Z * -0.12;
    assert!(min_det_f(&layer, &state) < -0.19);
    state.handles[0].x = f64::NAN;
    assert!(min_det_f(&layer, &state).is_nan());
}
