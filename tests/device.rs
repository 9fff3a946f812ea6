//! The potential on the device as a host sees it: the same bits whatever runs beside it, in step with the f64
//! evaluation, and a typed error for everything that can go wrong.
#![cfg(feature = "gpu")]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::gpu::{AdapterChoice, AdapterKind, Bindings, GpuDevice, Module, Waiting, adapters};
use supple::math::Random;
use supple::model::{Avatar, Frame, State};
use supple::potential::{Evaluation, Potential, StepStart, Trial};
use supple::reference::Reference;
use supple::sample::{random_avatar, random_state};
use supple::stage::{GpuOptions, GpuPotential, Sources};
use supple::{Error, GpuError, wgpu};

fn device() -> GpuDevice {
    pollster::block_on(GpuDevice::open(AdapterChoice::HardwareElseSoftware)).expect(
        "GPU tests need an adapter and never skip: install a Vulkan driver, \
         for example the package mesa-vulkan-drivers",
    )
}

/// One avatar's step: where it was, is, and is asked about.
struct Case {
    previous: State,
    current: State,
    states: [State; 3],
    colliders: Vec<Collider>,
}

fn case(seed: u64, avatar: &Avatar) -> Case {
    let random = &mut Random::new(seed);
    let mut moved = |state: &State| {
        let step: Vec<f64> = (0..avatar.space().dofs())
            .map(|_| random.uniform(-1e-3, 1e-3))
            .collect();
        state.moved(&step, 1.0)
    };
    let previous = random_state(seed, avatar, 0.3, 1e-3);
    let current = moved(&previous);
    let states = std::array::from_fn(|_| moved(&current));
    let place = |shape: Shape, random: &mut Random| {
        let frame = Frame {
            rotation: random.rotation(3.0),
            position: current.frames[0].position + random.vector(0.02),
        };
        Collider {
            shape,
            frame,
            previous: frame,
            stiffness: 1e6,
            margin: 3e-3,
        }
    };
    // A different number of colliders for each.
    let count = 1 + seed as usize % 4;
    let shapes = Shape::examples().into_iter().cycle().skip(seed as usize);
    let colliders = shapes.take(count).map(|s| place(s, random)).collect();
    Case {
        previous,
        current,
        states,
        colliders,
    }
}

fn start(case: &Case) -> StepStart<'_> {
    StepStart {
        time_step: 0.01,
        previous: &case.previous,
        current: &case.current,
        colliders: &case.colliders,
        tissue_gravity: DVec3::new(0.0, 0.0, -9.81),
    }
}

/// Everything that comes out of a step.
#[derive(Debug, Default, PartialEq)]
struct Outcome {
    evaluations: Vec<Evaluation>,
    differences: Vec<f64>,
    skins: Vec<(Vec<DVec3>, Vec<DVec3>)>,
}

/// What a batch of the lone runs' cases must give.
fn joined(lone: &[Outcome]) -> Outcome {
    let mut joined = Outcome::default();
    // Two evaluations an instance: first all firsts, then all seconds.
    for k in 0..2 {
        (joined.evaluations).extend(lone.iter().map(|o| o.evaluations[k].clone()));
        (joined.differences).extend(lone.iter().map(|o| o.differences[k]));
    }
    joined
        .skins
        .extend(lone.iter().flat_map(|o| o.skins.clone()));
    joined
}

fn run(potential: &mut impl Potential, cases: &[&Case]) -> Outcome {
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
        out.differences = vec![0.0; trials.len()];
        potential
            .energy_differences(&trials, &mut out.differences)
            .await
            .unwrap();
        let states: Vec<State> = cases.iter().map(|c| c.states[0].clone()).collect();
        potential.pose_skin(&states).await.unwrap();
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

fn potential(
    gpu: &GpuDevice,
    avatar: &Arc<Avatar>,
    instances: usize,
    options: GpuOptions,
) -> GpuPotential {
    GpuPotential::new(&gpu.device, &gpu.queue, avatar.clone(), instances, options).unwrap()
}

#[test]
fn a_batch_gives_each_avatar_the_bits_of_a_lone_run() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(7, 6, 12, 150, 300));
    let cases: Vec<Case> = (1..4).map(|seed| case(seed, &avatar)).collect();
    let lone: Vec<Outcome> = (cases.iter())
        .map(|c| {
            run(
                &mut potential(&gpu, &avatar, 1, GpuOptions::default()),
                &[c],
            )
        })
        .collect();
    assert!(lone.iter().all(|o| o.evaluations[0].contacts > 0));
    let cases: Vec<&Case> = cases.iter().collect();
    // Room for one state, for two and for all in the scratch buffers; trials in several submissions.
    for (scratch_bytes, trials) in [(1, 1), (5 << 20, 4), (128 << 20, 8)] {
        let options = GpuOptions {
            scratch_bytes,
            trials,
            ..GpuOptions::default()
        };
        let batch = run(&mut potential(&gpu, &avatar, 3, options), &cases);
        assert!(
            batch == joined(&lone),
            "scratch {scratch_bytes}, trials {trials}"
        );
    }
}

#[test]
fn the_same_input_gives_the_same_bits() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(3, 4, 8, 100, 200));
    let case = case(2, &avatar);
    let mut first = potential(&gpu, &avatar, 1, GpuOptions::default());
    let once = run(&mut first, &[&case]);
    // The second time x̄ of the drawn skin is of another pose than the step's start.
    assert_eq!(once, run(&mut first, &[&case]));
    let mut fresh = potential(&gpu, &avatar, 1, GpuOptions::default());
    assert_eq!(once, run(&mut fresh, &[&case]));
    // And here it is of the very pose, and carried over.
    pollster::block_on(fresh.pose_skin(std::slice::from_ref(&case.current))).unwrap();
    assert_eq!(once, run(&mut fresh, &[&case]));
}

#[test]
fn inactive_instances_are_left_alone() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(4, 4, 8, 100, 200));
    let cases: Vec<Case> = (1..4).map(|seed| case(seed, &avatar)).collect();
    let mut potential = potential(&gpu, &avatar, 3, GpuOptions::default());
    let starts: Vec<_> = cases.iter().map(start).collect();
    pollster::block_on(async {
        potential.begin_step(&starts, &[true; 3]).await.unwrap();
        let states: Vec<State> = cases.iter().map(|c| c.states[0].clone()).collect();
        let mut all = vec![Evaluation::default(); 3];
        potential
            .evaluate(&states, &[true; 3], &mut all)
            .await
            .unwrap();
        let mut some = vec![Evaluation::default(); 3];
        let active = [false, false, true];
        potential
            .evaluate(&states, &active, &mut some)
            .await
            .unwrap();
        assert_eq!(some[2], all[2]);
        assert_eq!(some[..2], [Evaluation::default(), Evaluation::default()]);
        // A step begun by one alone changes nothing for the others.
        potential.begin_step(&starts, &active).await.unwrap();
        potential
            .evaluate(&states, &[true; 3], &mut some)
            .await
            .unwrap();
        assert_eq!(some, all);
        // Nobody at all.
        let nobody = [false; 3];
        potential.begin_step(&starts, &nobody).await.unwrap();
        potential
            .evaluate(&states, &nobody, &mut some)
            .await
            .unwrap();
        potential.energy_differences(&[], &mut []).await.unwrap();
        assert_eq!(some, all);
    });
}

#[test]
fn it_agrees_with_the_f64_evaluation() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(5, 6, 12, 150, 300));
    let touching = case(3, &avatar);
    let mut free = case(4, &avatar);
    free.colliders.clear();
    for case in [touching, free] {
        agrees(&gpu, &avatar, &case);
    }
}

fn agrees(gpu: &GpuDevice, avatar: &Arc<Avatar>, case: &Case) {
    let mut on_device = potential(gpu, avatar, 1, GpuOptions::default());
    let mut reference = Reference::new(avatar.clone(), 1, 2048).unwrap();
    let (got, want) = (run(&mut on_device, &[case]), run(&mut reference, &[case]));
    // Some hundred roundings of 6e-8 in each of a few stages; tests of single kernels bound them sharply.
    let tolerance = 1e-4;
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    for (got, want) in got.evaluations.iter().zip(&want.evaluations) {
        assert_eq!(got.contacts, want.contacts);
        let pairs = || got.gradient.iter().zip(&want.gradient);
        let error = norm(&mut pairs().map(|(a, b)| a - b));
        let size = norm(&mut want.gradient.iter().copied());
        assert!(error <= tolerance * size, "gradient: {error} of {size}");
        let pairs = || {
            got.hessian
                .iter()
                .flatten()
                .zip(want.hessian.iter().flatten())
        };
        let error = norm(&mut pairs().map(|(a, b)| a - b));
        let size = norm(&mut want.hessian.iter().flatten().copied());
        assert!(error <= tolerance * size, "Hessian: {error} of {size}");
        let force = (got.contact_force - want.contact_force).length();
        assert!(force <= tolerance * want.contact_force.length());
    }
    for (got, want) in got.skins[0].0.iter().zip(&want.skins[0].0) {
        assert!((*got - *want).length() < 1e-7, "skin: {got} and {want}");
    }
    for (got, want) in got.skins[0].1.iter().zip(&want.skins[0].1) {
        assert!((*got - *want).length() < 1e-4, "normals: {got} and {want}");
    }
    for (got, want) in got.differences.iter().zip(&want.differences) {
        assert!(
            (got - want).abs() <= 1e-3 * want.abs(),
            "trials: {got} and {want}"
        );
    }
}

/// The GPU error of a result that must be one.
fn gpu_error<T>(result: supple::Result<T>) -> GpuError {
    match result {
        Err(Error::Gpu(error)) => error,
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("no error"),
    }
}

#[test]
fn what_goes_wrong_has_a_type() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(6, 3, 5, 40, 100));
    let case = case(1, &avatar);
    let mut out = [Evaluation::default()];
    let mut on_device = potential(&gpu, &avatar, 1, GpuOptions::default());
    let state = [case.states[0].clone()];

    let result = pollster::block_on(on_device.evaluate(&state, &[true], &mut out));
    assert!(matches!(result, Err(Error::Invalid { .. })), "{result:?}");

    let mut broken = state.clone();
    broken[0].handles[2].y = f64::NAN;
    pollster::block_on(on_device.begin_step(&[start(&case)], &[true])).unwrap();
    let result = pollster::block_on(on_device.evaluate(&broken, &[true], &mut out));
    assert!(matches!(result, Err(Error::NotFinite { .. })), "{result:?}");

    // Finite in f64, but not what comes out of f32.
    broken[0].handles[2].y = 1e30;
    let result = pollster::block_on(on_device.evaluate(&broken, &[true], &mut out));
    assert!(matches!(result, Err(Error::NotFinite { .. })), "{result:?}");

    let many = vec![case.colliders[0]; 9];
    let crowded = StepStart {
        colliders: &many,
        ..start(&case)
    };
    let error = gpu_error(pollster::block_on(
        on_device.begin_step(&[crowded], &[true]),
    ));
    assert!(matches!(error, GpuError::Limit { .. }), "{error}");

    let narrow = GpuOptions {
        contacts: 2,
        ..GpuOptions::default()
    };
    let mut on_device = potential(&gpu, &avatar, 1, narrow);
    pollster::block_on(on_device.begin_step(&[start(&case)], &[true])).unwrap();
    let error = gpu_error(pollster::block_on(on_device.evaluate(
        &state,
        &[true],
        &mut out,
    )));
    assert!(matches!(error, GpuError::Limit { limit: 2, .. }), "{error}");

    let sources = Sources::new(&avatar.material)
        .edited("displacement.wgsl", "fn displacement(", "fn displacement((")
        .unwrap();
    let options = GpuOptions {
        sources: Some(sources),
        ..GpuOptions::default()
    };
    let error = gpu_error(GpuPotential::new(
        &gpu.device,
        &gpu.queue,
        avatar,
        1,
        options,
    ));
    assert!(matches!(error, GpuError::Shader { .. }), "{error}");
    assert!(error.to_string().contains("displacement"), "{error}");

    let source = "@group(0) @binding(0) var<storage, read_write> numbers: array<f32>;\n\
                  @compute @workgroup_size(1) fn main() { numbers[0] = 1.0; }";
    let module = Module::parse("lonely", source.to_owned()).unwrap();
    let error = gpu_error(module.kernel(&gpu.device, "main", &Bindings::default()));
    assert!(matches!(error, GpuError::MissingBuffer { .. }), "{error}");
    assert!(error.to_string().contains("numbers"), "{error}");
}

#[test]
fn a_host_may_drive_the_device() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(8, 3, 5, 40, 100));
    let case = case(1, &avatar);
    let blocking = run(
        &mut potential(&gpu, &avatar, 1, GpuOptions::default()),
        &[&case],
    );
    let options = GpuOptions {
        waiting: Waiting::Host,
        ..GpuOptions::default()
    };
    let mut waiting = potential(&gpu, &avatar, 1, options);
    let done = AtomicBool::new(false);
    std::thread::scope(|scope| {
        scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                gpu.device.poll(wgpu::PollType::Poll).unwrap();
                std::thread::yield_now();
            }
        });
        let outcome = run(&mut waiting, &[&case]);
        done.store(true, Ordering::Relaxed);
        assert_eq!(outcome, blocking);
    });
}

#[test]
fn a_lost_device_is_an_error() {
    let gpu = device();
    let avatar = Arc::new(random_avatar(9, 3, 5, 40, 100));
    let case = case(1, &avatar);
    let mut on_device = potential(&gpu, &avatar, 1, GpuOptions::default());
    pollster::block_on(on_device.begin_step(&[start(&case)], &[true])).unwrap();
    gpu.device.destroy();
    let state = std::slice::from_ref(&case.states[0]);
    let mut out = [Evaluation::default()];
    let error = gpu_error(pollster::block_on(on_device.evaluate(
        state,
        &[true],
        &mut out,
    )));
    assert!(matches!(error, GpuError::DeviceLost(_)), "{error}");
}

#[test]
fn adapters_are_listed_with_their_kind() {
    let gpu = device();
    let listed = pollster::block_on(adapters());
    assert!(listed.contains(&gpu.adapter));
    assert!(!gpu.adapter.name.is_empty() && !gpu.adapter.backend.is_empty());
    if listed.iter().all(|a| a.kind == AdapterKind::Software) {
        let refused = pollster::block_on(GpuDevice::open(AdapterChoice::Hardware));
        assert!(matches!(gpu_error(refused), GpuError::NoAdapter(_)));
    }
}
