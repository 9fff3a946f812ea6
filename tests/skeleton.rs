//! Every term of the skeleton alone: its gradient is the derivative of its energy, its Hessian is
//! positive semi-definite, and exact where the residual vanishes.

use supple::glam::DVec3;
use supple::math::Random;
use supple::model::{Avatar, Frame, pose_feature};
use supple::sample::random_avatar;
use supple::skeleton::{
    Bending, BendingSpring, BoneInertia, FrameGravity, FrameHessian, FrameTerm, JointSpring,
    Spring, TissueMoments, Tracking, TrackingSpring,
};

const BONES: usize = 3;
const DOFS: usize = 6 * BONES;
const TIME_STEP: f64 = 0.01;

fn avatar() -> Avatar {
    random_avatar(11, BONES, 4, 40, 12)
}

/// Frames that differ from the bind pose by up to `angle` rad and `distance` m.
fn frames(random: &mut Random, angle: f64, distance: f64) -> Vec<Frame> {
    let moved = |joint: &DVec3| Frame {
        rotation: random.rotation(angle),
        position: *joint + random.vector(distance),
    };
    avatar().skeleton.joints.iter().map(moved).collect()
}

fn moved(frames: &[Frame], dof: usize, step: f64) -> Vec<Frame> {
    let mut out = frames.to_vec();
    let (block, axis) = (dof / 3, DVec3::AXES[dof % 3] * step);
    let frame = &mut out[block / 2];
    *frame = match block % 2 {
        0 => frame.moved(axis, DVec3::ZERO),
        _ => frame.moved(DVec3::ZERO, axis),
    };
    out
}

fn derivatives(term: &dyn FrameTerm, frames: &[Frame]) -> (Vec<f64>, Vec<[f64; DOFS]>) {
    let rows = 2 * BONES;
    let mut gradient = vec![0.0; DOFS];
    let mut packed = vec![[0.0; 9]; rows * (rows + 1) / 2];
    let hessian = &mut FrameHessian::new(&mut packed, BONES);
    term.add_derivatives(frames, &mut gradient, hessian);
    let mut full = vec![[0.0; DOFS]; DOFS];
    for row in 0..rows {
        for column in 0..=row {
            let block = &packed[row * (row + 1) / 2 + column];
            for (k, value) in block.iter().enumerate() {
                let (r, c) = (3 * row + k % 3, 3 * column + k / 3);
                full[r][c] = *value;
                if row != column {
                    full[c][r] = *value;
                }
            }
        }
    }
    (gradient, full)
}

/// A term, with a pose near which its residual vanishes exactly at `rest`.
struct Case {
    name: &'static str,
    term: Box<dyn FrameTerm>,
    rest: Option<Vec<Frame>>,
}

fn cases() -> Vec<Case> {
    let (avatar, random) = (avatar(), &mut Random::new(3));
    let (previous, current) = (frames(random, 1.0, 0.02), frames(random, 1.2, 0.02));
    let spring = |stiffness, damping| Some(Spring { stiffness, damping });
    let mut target = Tracking {
        bone: 1,
        frame: frames(random, 1.0, 0.02)[1],
        previous: frames(random, 1.0, 0.02)[1],
        rotation: spring(30.0, 0.4),
        position: None,
    };
    let mut on_target = frames(random, 1.0, 0.02);
    on_target[1] = target.frame;
    let rotation = TrackingSpring::new(target, &current, TIME_STEP);
    (target.rotation, target.position) = (None, spring(800.0, 3.0));
    let position = TrackingSpring::new(target, &current, TIME_STEP);
    (target.rotation, target.position) = (spring(30.0, 0.0), spring(800.0, 0.0));
    let undamped = TrackingSpring::new(target, &current, TIME_STEP);

    let offset = avatar.skeleton.joints[2] - avatar.skeleton.joints[0];
    let joint = JointSpring {
        child: 2,
        parent: 0,
        offset,
        stiffness: 1e4,
    };
    let mut closed = frames(random, 1.0, 0.02);
    closed[2].position = closed[0].transform(offset);
    let rest_rotation = random.rotation(0.8);
    let bending = BendingSpring {
        child: 2,
        parent: 1,
        bending: Bending {
            rest_rotation,
            stiffness: 12.0,
        },
    };
    let mut unbent = frames(random, 1.0, 0.02);
    unbent[2].rotation = unbent[1].rotation * rest_rotation;
    let mass = &avatar.bone_masses[1];
    let moving = BoneInertia::new(1, mass, &previous[1], &current[1], TIME_STEP);
    let resting = BoneInertia::new(1, mass, &current[1], &current[1], TIME_STEP);
    let moments: Vec<_> = avatar.bone_masses.iter().map(|b| b.moments()).collect();
    let gravity = FrameGravity::new(
        DVec3::new(1.0, 2.0, -9.0),
        &moments,
        Some(&TissueMoments::new(&avatar)),
        &current,
    );
    let case = |name, term: Box<dyn FrameTerm>, rest| Case { name, term, rest };
    vec![
        case("joint", Box::new(joint), Some(closed)),
        case("bending", Box::new(bending), Some(unbent)),
        case("damped rotation tracking", Box::new(rotation), None),
        case("damped position tracking", Box::new(position), None),
        case("tracking", Box::new(undamped), Some(on_target)),
        case("inertia in motion", Box::new(moving), None),
        case("inertia at rest", Box::new(resting), Some(current)),
        case("gravity", Box::new(gravity), None),
    ]
}

#[test]
fn gradients_are_derivatives_of_the_energies() {
    let random = &mut Random::new(4);
    let step = 1e-5;
    for case in cases() {
        let q = frames(random, 1.5, 0.03);
        let (gradient, _) = derivatives(&*case.term, &q);
        let size = gradient.iter().fold(0.0, |a: f64, g| a.max(g.abs()));
        assert!(size > 1e-3, "{}: the gradient vanishes", case.name);
        for dof in 0..DOFS {
            let (back, forth) = (moved(&q, dof, -step), moved(&q, dof, step));
            let difference = case.term.difference(&back, &forth) / (2.0 * step);
            let error = (difference - gradient[dof]).abs() / size;
            // Truncation is O(step² |r|), rounding ε / step.
            assert!(error < 1e-8, "{}, DoF {dof}: {error:e}", case.name);
        }
    }
}

#[test]
fn energy_differences_add_up_and_keep_their_digits() {
    let random = &mut Random::new(5);
    for case in cases() {
        let [a, b, c] = [0; 3].map(|_| frames(random, 1.5, 0.03));
        let difference = |from: &[Frame], to: &[Frame]| case.term.difference(from, to);
        let (ab, bc, ac) = (difference(&a, &b), difference(&b, &c), difference(&a, &c));
        let size = ab.abs() + bc.abs() + ac.abs();
        assert!(size > 1e-4, "{}: the energy vanishes", case.name);
        assert!((ab + bc - ac).abs() < 1e-12 * size, "{}", case.name);
        assert_eq!(difference(&a, &a), 0.0, "{}", case.name);
        // A move of 1e-9 m or rad is seen with its first-order value to seven digits.
        let (gradient, _) = derivatives(&*case.term, &a);
        let size = gradient.iter().fold(0.0, |a: f64, g| a.max(g.abs()));
        for dof in 0..DOFS {
            let tiny = difference(&moved(&a, dof, -1e-9), &moved(&a, dof, 1e-9)) / 2e-9;
            assert!(
                (tiny - gradient[dof]).abs() < 1e-6 * size,
                "{}, DoF {dof}",
                case.name
            );
        }
    }
}

#[test]
fn hessians_are_positive_semi_definite() {
    let random = &mut Random::new(6);
    for case in cases() {
        let q = frames(random, 2.0, 0.03);
        let (_, hessian) = derivatives(&*case.term, &q);
        let matrix = faer::Mat::from_fn(DOFS, DOFS, |i, j| hessian[i][j]);
        let values = matrix.self_adjoint_eigenvalues(faer::Side::Lower).unwrap();
        let largest = values[DOFS - 1];
        assert!(largest > 0.0 || case.name == "gravity", "{}", case.name);
        assert!(values[0] >= -1e-13 * largest, "{}: {values:?}", case.name);
    }
}

#[test]
fn hessians_are_exact_where_the_residual_vanishes() {
    let step = 1e-5;
    for case in cases() {
        let Some(rest) = case.rest else { continue };
        let (gradient, hessian) = derivatives(&*case.term, &rest);
        let size = hessian
            .iter()
            .flatten()
            .fold(0.0, |a: f64, h| a.max(h.abs()));
        let force = gradient.iter().fold(0.0, |a: f64, g| a.max(g.abs()));
        assert!(force < 1e-12 * size, "{}: {force:e}", case.name);
        for dof in 0..DOFS {
            let (back, _) = derivatives(&*case.term, &moved(&rest, dof, -step));
            let (forth, _) = derivatives(&*case.term, &moved(&rest, dof, step));
            for row in 0..DOFS {
                let difference = (forth[row] - back[row]) / (2.0 * step);
                let error = (difference - hessian[row][dof]).abs() / size;
                assert!(error < 1e-8, "{}, ({row}, {dof}): {error:e}", case.name);
            }
        }
    }
}

/// Bone inertia against its own definition: a sum over grains of matter.
#[test]
fn bone_inertia_is_that_of_its_matter() {
    let random = &mut Random::new(7);
    let grains: Vec<(f64, DVec3)> = (0..20)
        .map(|_| (random.uniform(0.001, 0.01), random.vector(0.05)))
        .collect();
    let mut second_moment = [[0.0; 4]; 4];
    for (mass, place) in &grains {
        let y = place.extend(1.0).to_array();
        for i in 0..4 {
            for j in 0..4 {
                second_moment[i][j] += mass * y[i] * y[j];
            }
        }
    }
    let mass = supple::model::BoneMass { second_moment };
    let [previous, current, a, b] = [0; 4].map(|_| frames(random, 1.0, 0.02)[0]);
    let term = BoneInertia::new(0, &mass, &previous, &current, TIME_STEP);
    let energy = |frame: &Frame| -> f64 {
        let inertia = |&(mass, y): &(f64, DVec3)| {
            let predicted = 2.0 * current.transform(y) - previous.transform(y);
            0.5 * mass * (frame.transform(y) - predicted).length_squared() / TIME_STEP.powi(2)
        };
        grains.iter().map(inertia).sum()
    };
    let expected = energy(&b) - energy(&a);
    let error = (term.difference(&[a], &[b]) - expected).abs();
    assert!(error < 1e-12 * (energy(&a) + energy(&b)), "{error:e}");
}

/// Gravity against its own definition: the weight of every point at φ = 0, with its blend shapes.
#[test]
fn gravity_is_the_weight_of_tissue_and_bones() {
    let (avatar, random) = (avatar(), &mut Random::new(8));
    let [current, a, b] = [0; 3].map(|_| frames(random, 1.0, 0.02));
    let g = DVec3::new(1.0, 2.0, -9.0);
    let moments: Vec<_> = avatar.bone_masses.iter().map(|b| b.moments()).collect();
    let tissue = TissueMoments::new(&avatar);
    let term = FrameGravity::new(g, &moments, Some(&tissue), &current);

    let (points, joints) = (&avatar.cubature, &avatar.skeleton.joints);
    let feature = pose_feature(&avatar.skeleton.parents, &current);
    let energy = |frames: &[Frame]| -> f64 {
        let blended = |i: usize| -> DVec3 {
            let column = |k: usize| points.pose_blend.columns[k * points.len() + i];
            let shapes = (0..feature.len())
                .map(|k| feature[k] * DVec3::from(column(k).map(f64::from)))
                .sum::<DVec3>();
            points.position[i] + shapes
        };
        let weight = |i: usize| -> f64 {
            let posed = points.skinning.row(i).iter().map(|w| {
                let j = w.bone as usize;
                w.weight * frames[j].transform(blended(i) - joints[j])
            });
            -avatar.density * points.measure[i] * g.dot(posed.sum())
        };
        let bone = |j: usize| {
            let (mass, first) = moments[j];
            -g.dot(frames[j].rotation * first + mass * frames[j].position)
        };
        (0..points.len()).map(weight).sum::<f64>() + (0..BONES).map(bone).sum::<f64>()
    };
    let expected = energy(&b) - energy(&a);
    let error = (term.difference(&a, &b) - expected).abs();
    let size = energy(&a).abs() + energy(&b).abs();
    assert!(
        error < 1e-12 * size && expected.abs() > 1e-3 * size,
        "{error:e} of {size}"
    );
}
