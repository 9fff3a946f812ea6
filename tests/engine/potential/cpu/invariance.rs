//! The drawn skin is the parametric model's; a rigid motion of the whole scene changes nothing.

use super::batches::triples;
use super::{avatar, floor, start};
use pollster::block_on;
use supple::collider::Collider;
use supple::glam::DVec3;
use supple::internal::cpu::min_det_f;
use supple::internal::features::pose_feature;
use supple::internal::math::Random;
use supple::internal::random_state;
use supple::model::{Avatar, Frame, State, Surface};
use supple::potential::{CpuPotential, Evaluation, Potential, StepStart};

/// Skin vertex `v` with x̄ of the pose `frames`, written out.
pub fn posed(avatar: &Avatar, v: usize, frames: &[Frame], state: &State) -> DVec3 {
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
    let mut potential = CpuPotential::new(avatar.clone(), 1).unwrap();
    block_on(potential.pose_skin(std::slice::from_ref(&state), &[], &[])).unwrap();
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
        awake: Vec::new(),
    };
    let evaluate = |states: [&State; 3], collider: Collider, tissue_gravity| {
        let mut potential = CpuPotential::new(avatar.clone(), 1).unwrap();
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
fn min_det_f_sees_the_worst_tet() {
    let avatar = avatar();
    let mut state = avatar.rest_state();
    assert!((min_det_f(&avatar, &state) - 1.0).abs() < 1e-12);
    // Without a handle on it, every node of the cube follows handle 0 alone, by half.
    let mut avatar = Avatar::clone(&avatar);
    avatar.layer.basis = (avatar.layer)
        .bone_of_node
        .iter()
        .map(|bone| bone.is_none().then_some((0, 0.5)))
        .collect();
    // The upper face (0.1 m above the fixed one) moves down by half of 0.16 m: det F = 1 − 0.8.
    state.handles[0] = DVec3::new(0.05, -0.02, -0.16);
    assert!((min_det_f(&avatar, &state) - 0.2).abs() < 1e-12);
    // One node alone: the worst tet is worse than the mean.
    avatar.layer.basis = (0..8).map(|n| (n == 7).then_some((0, 1.0))).collect();
    state.handles[0] = DVec3::Z * -0.12;
    assert!(min_det_f(&avatar, &state) < -0.19);
    state.handles[0].x = f64::NAN;
    assert!(min_det_f(&avatar, &state).is_nan());
}
