//! A random step of an avatar, and everything that comes out of it.

use std::sync::Arc;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::gpu::{AdapterChoice, GpuDevice};
use supple::internal::math::Random;
use supple::internal::{pose_offsets, random_state};
use supple::model::{Avatar, Frame, InertialTarget, State};
use supple::potential::{
    Difference, Evaluation, GpuOptions, GpuPotential, Potential, StepEnd, StepStart, TissueFactors,
    Trial,
};

pub fn device() -> GpuDevice {
    pollster::block_on(GpuDevice::open(AdapterChoice::HardwareElseSoftware)).expect(
        "GPU tests need an adapter and never skip: install a Vulkan driver, \
         for example the package mesa-vulkan-drivers",
    )
}

/// One avatar's step: where it was, is, and is asked about.
pub struct Case {
    pub past: [State; 3],
    pub current: State,
    pub states: [State; 3],
    pub colliders: Vec<Collider>,
    pub prescribed: Vec<bool>,
    /// Of the skin; of every third seed there are none.
    pub offsets: Vec<[f32; 3]>,
}

pub fn case(seed: u64, avatar: &Avatar) -> Case {
    let random = &mut Random::new(seed);
    let mut moved = |state: &State| {
        let step: Vec<f64> = (0..avatar.space().dofs())
            .map(|_| random.uniform(-1e-3, 1e-3))
            .collect();
        state.moved(&step, 1.0)
    };
    let first = random_state(seed, avatar, 0.3, 1e-3);
    let second = moved(&first);
    let previous = moved(&second);
    let current = moved(&previous);
    let states = std::array::from_fn(|_| moved(&current));
    let place = |shape: Shape, random: &mut Random| {
        let frame = Frame {
            rotation: random.rotation(3.0),
            position: current.frames[0].position + random.vector(0.02),
        };
        Collider {
            stiffness: Some(1e6),
            margin: 3e-3,
            friction: 0.5,
            previous: frame.moved(random.vector(1e-3), random.vector(0.01)),
            ..Collider::new(shape, frame)
        }
    };
    // A different number of colliders for each.
    let count = 1 + seed as usize % 4;
    let shapes = Shape::examples().into_iter().cycle().skip(seed as usize);
    let colliders = shapes.take(count).map(|s| place(s, random)).collect();
    Case {
        past: [previous, second, first],
        current,
        states,
        colliders,
        // Another frame of each.
        prescribed: (0..avatar.skeleton.len())
            .map(|frame| frame == seed as usize % avatar.skeleton.len())
            .collect(),
        offsets: match seed % 3 {
            0 => Vec::new(),
            _ => pose_offsets(seed, avatar, 5e-3),
        },
    }
}

pub fn start(case: &Case) -> StepStart<'_> {
    StepStart {
        time_step: 0.01,
        // As after two steps of unlike lengths.
        inertia: InertialTarget {
            past: &case.past,
            weights: [-2.4, 0.9, -0.15],
            drift: 0.3,
            step: 0.007,
            share: None,
        },
        current: &case.current,
        colliders: &case.colliders,
        tissue_gravity: DVec3::new(0.0, 0.0, -9.81),
        slip_speed: 1e-3,
        geometric_contact: true,
        factors: TissueFactors::default(),
        pose_offsets: &case.offsets,
        prescribed: &case.prescribed,
    }
}

/// Everything that comes out of a step.
#[derive(Debug, Default, PartialEq)]
pub struct Outcome {
    pub evaluations: Vec<Evaluation>,
    pub differences: Vec<Difference>,
    pub skins: Vec<(Vec<DVec3>, Vec<DVec3>)>,
    pub ends: Vec<StepEnd>,
}

/// What a batch of the lone runs' cases must give.
pub fn joined(lone: &[Outcome]) -> Outcome {
    let mut joined = Outcome::default();
    // Two evaluations an instance: first all firsts, then all seconds.
    for k in 0..2 {
        (joined.evaluations).extend(lone.iter().map(|o| o.evaluations[k].clone()));
        (joined.differences).extend(lone.iter().map(|o| o.differences[k]));
    }
    joined
        .skins
        .extend(lone.iter().flat_map(|o| o.skins.clone()));
    joined.ends.extend(lone.iter().flat_map(|o| o.ends.clone()));
    joined
}

pub fn run(potential: &mut impl Potential, cases: &[&Case]) -> Outcome {
    pollster::block_on(async {
        let active = vec![true; cases.len()];
        let starts: Vec<_> = cases.iter().map(|c| start(c)).collect();
        potential.begin_step(&starts, &active).await.unwrap();
        let mut out = Outcome::default();
        for k in 0..2 {
            let states: Vec<State> = cases.iter().map(|c| c.states[k].clone()).collect();
            let mut evaluations = vec![Evaluation::default(); cases.len()];
            potential
                .evaluate(&states, &active, &mut evaluations)
                .await
                .unwrap();
            out.evaluations.extend(evaluations);
        }
        out.ends = vec![StepEnd::default(); cases.len()];
        let states: Vec<State> = cases.iter().map(|c| c.states[1].clone()).collect();
        potential
            .end_step(&states, &active, &mut out.ends)
            .await
            .unwrap();
        let trials: Vec<Trial<'_>> = [(0, 1), (1, 2)]
            .into_iter()
            .flat_map(|(from, to)| {
                cases.iter().enumerate().map(move |(instance, c)| Trial {
                    instance,
                    base: &c.states[from],
                    state: &c.states[to],
                })
            })
            .collect();
        out.differences = vec![Difference::default(); trials.len()];
        potential
            .energy_differences(&trials, &mut out.differences)
            .await
            .unwrap();
        let states: Vec<State> = cases.iter().map(|c| c.states[0].clone()).collect();
        let offsets: Vec<_> = cases.iter().map(|c| &c.offsets[..]).collect();
        potential.pose_skin(&states, &offsets, &[]).await.unwrap();
        for i in 0..cases.len() {
            let (mut positions, mut normals) = (Vec::new(), Vec::new());
            potential
                .read_skin(i, &mut positions, &mut normals)
                .await
                .unwrap();
            out.skins.push((positions, normals));
        }
        out
    })
}

pub fn potential(
    gpu: &GpuDevice,
    avatar: &Arc<Avatar>,
    instances: usize,
    options: GpuOptions,
) -> GpuPotential {
    GpuPotential::new(&gpu.device, &gpu.queue, avatar.clone(), instances, options).unwrap()
}
