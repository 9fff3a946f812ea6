//! Terms of the skeleton against their own definitions.

use supple::glam::DVec3;
use supple::internal::cpu::pose_blend::pose_offset;
use supple::internal::features::pose_feature;
use supple::internal::math::Random;
use supple::internal::skeleton::{BoneInertia, FrameGravity, FrameTerm, TissueMoments};
use supple::internal::{pose_offsets, random_avatar};
use supple::model::{Avatar, Frame, InertialTarget, State};

const BONES: usize = 3;
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
    let [previous, earlier, current, a, b] = [0; 5].map(|_| frames(random, 1.0, 0.02)[0]);
    let [previous, earlier] = [previous, earlier].map(|frame| State {
        frames: vec![frame],
        handles: Vec::new(),
        awake: Vec::new(),
    });
    // As after two steps of unlike lengths.
    let weights = [-2.4, 0.9, 0.0];
    let past = [previous, earlier];
    let target = InertialTarget {
        past: &past,
        weights,
        drift: 0.3,
        step: TIME_STEP,
        share: None,
    };
    let term = BoneInertia::new(0, &mass, &target, &current);
    let energy = |frame: &Frame| -> f64 {
        let inertia = |&(mass, y): &(f64, DVec3)| {
            let moved = |k: usize| past[k].frames[0].transform(y) - current.transform(y);
            let predicted = current.transform(y) + weights[0] * moved(0) + weights[1] * moved(1);
            0.5 * mass * (frame.transform(y) - predicted).length_squared() / TIME_STEP.powi(2)
        };
        grains.iter().map(inertia).sum()
    };
    let expected = energy(&b) - energy(&a);
    let error = (term.difference(&[a], &[b]) - expected).abs();
    assert!(error < 1e-12 * (energy(&a) + energy(&b)), "{error:e}");
}

/// Gravity against its own definition: the weight of every point at φ = 0, with its blend shapes and what it follows of
/// a host's offsets.
#[test]
fn gravity_is_the_weight_of_tissue_and_bones() {
    let (avatar, random) = (avatar(), &mut Random::new(8));
    let [current, a, b] = [0; 3].map(|_| frames(random, 1.0, 0.02));
    let g = DVec3::new(1.0, 2.0, -9.0);
    let moments: Vec<_> = avatar.bone_masses.iter().map(|b| b.moments()).collect();
    let tissue = TissueMoments::new(&avatar);
    let offsets = pose_offsets(9, &avatar, 0.02);
    let term = FrameGravity::new(g, &moments, Some((&tissue, 1.0)), &current, &offsets);

    let (points, joints) = (&avatar.cubature, &avatar.skeleton.joints);
    let feature = pose_feature(&avatar.skeleton.parents, &current);
    let energy = |frames: &[Frame]| -> f64 {
        let blended = |i: usize| -> DVec3 {
            let column = |k: usize| points.pose_blend.columns[k * points.len() + i];
            let shapes = (0..feature.len())
                .map(|k| feature[k] * DVec3::from(column(k).map(f64::from)))
                .sum::<DVec3>();
            points.position[i] + shapes + pose_offset(avatar.pose_extension.row(i), &offsets)
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
