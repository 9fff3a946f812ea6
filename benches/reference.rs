//! The f64 evaluation of a hand-sized avatar: 16 bones, 87 handles (357 DoFs), 3,100 skin vertices, 135 pose
//! columns, two colliders in touch.

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use std::sync::Arc;
use supple::collider::{Collider, Shape};
use supple::glam::{DMat3, DVec3};
use supple::internal::{random_avatar, random_state};
use supple::model::{Frame, InertialTarget, State};
use supple::potential::{
    CpuPotential, Difference, Evaluation, Potential, StepEnd, StepStart, TissueFactors, Trial,
};

const BONES: usize = 16;
const HANDLES: usize = 87;
const VERTICES: usize = 3100;

fn hand_sized(points: usize) -> Arc<supple::model::Avatar> {
    let mut avatar = random_avatar(1, BONES, HANDLES, points, VERTICES);
    // Random bones would pull neighbours far apart: put all joints in one place, so that the skin stays a torus.
    avatar.skeleton.joints.fill(DVec3::ZERO);
    Arc::new(avatar)
}

fn colliders() -> [Collider; 2] {
    let collider = |shape, position, rotation| Collider {
        margin: 1e-3,
        ..Collider::new(shape, Frame { rotation, position })
    };
    let cylinder = Shape::Cylinder {
        radius: 0.008,
        half_length: 0.2,
    };
    [
        collider(
            cylinder,
            DVec3::new(0.0, 0.0, -0.022),
            DMat3::from_rotation_y(1.57),
        ),
        collider(
            Shape::HalfSpace,
            DVec3::new(0.0, 0.0, -0.02),
            DMat3::IDENTITY,
        ),
    ]
}

fn bench(criterion: &mut Criterion) {
    for points in [700, 2000] {
        let avatar = hand_sized(points);
        let mut potential = CpuPotential::new(avatar.clone(), 1).expect("a valid avatar");
        let [previous, current, state] =
            [1, 2, 3].map(|seed| random_state(seed, &avatar, 0.05, 0.001));
        let colliders = colliders();
        let start = StepStart {
            time_step: 0.01,
            inertia: InertialTarget::backward_euler(&previous, 0.01),
            current: &current,
            colliders: &colliders,
            tissue_gravity: DVec3::ZERO,
            slip_speed: 1e-3,
            geometric_contact: false,
            factors: TissueFactors::default(),
            pose_offsets: &[],
            prescribed: &[],
        };
        let states: [State; 1] = [state];
        let mut out = [Evaluation::default()];
        let mut group = criterion.benchmark_group(format!("reference/{points} points"));
        group.bench_function("begin_step", |b| {
            b.iter(|| pollster::block_on(potential.begin_step(black_box(&[start]), &[true])));
        });
        group.bench_function("evaluate", |b| {
            b.iter(|| {
                pollster::block_on(potential.evaluate(black_box(&states), &[true], &mut out))
            });
        });
        let contacts = out[0].contacts;
        let mut ends = [StepEnd::default()];
        group.bench_function("end_step", |b| {
            b.iter(|| {
                pollster::block_on(potential.end_step(black_box(&states), &[true], &mut ends))
            });
        });
        group.bench_function("pose_skin", |b| {
            b.iter(|| pollster::block_on(potential.pose_skin(black_box(&states), &[], &[])));
        });
        group.bench_function("whole step", |b| {
            b.iter(|| {
                pollster::block_on(async {
                    potential.begin_step(black_box(&[start]), &[true]).await?;
                    potential.evaluate(&states, &[true], &mut out).await?;
                    potential.pose_skin(&states, &[], &[]).await
                })
            });
        });
        let trial = Trial {
            instance: 0,
            base: &current,
            state: &states[0],
        };
        let mut differences = [Difference::default()];
        group.bench_function("energy_difference", |b| {
            b.iter(|| {
                pollster::block_on(
                    potential.energy_differences(black_box(&[trial]), &mut differences),
                )
            });
        });
        let prescribed = [true; BONES];
        let held = StepStart {
            prescribed: &prescribed,
            ..start
        };
        pollster::block_on(potential.begin_step(&[held], &[true])).expect("a valid start");
        group.bench_function("evaluate with all bones prescribed", |b| {
            b.iter(|| {
                pollster::block_on(potential.evaluate(black_box(&states), &[true], &mut out))
            });
        });
        let free = StepStart {
            colliders: &[],
            ..start
        };
        pollster::block_on(potential.begin_step(&[free], &[true])).expect("a valid start");
        group.bench_function("evaluate without contact", |b| {
            b.iter(|| {
                pollster::block_on(potential.evaluate(black_box(&states), &[true], &mut out))
            });
        });
        group.finish();
        println!("{contacts} contacts active");
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);
