//! Worlds on the GPU: in step with those on the CPU, one submission a question, the skin where it is drawn from.

use super::{contacts, limb, previous_skins, springs};
use supple::collider::Shape;
use supple::glam::{DVec3, Vec3};
use supple::gpu::{AdapterChoice, GpuDevice};
use supple::model::{Frame, Integrator, RigidBody, State, UpAxis};
use supple::sim::{Settings, SolverMode, SpringMode};
use supple::world::{Backend, BodyId, InstanceId};
use supple::{Result, World, wgpu};

/// The limbs' radius and half the box, m.
const APART: f64 = 0.04 + 0.03;

fn device() -> GpuDevice {
    pollster::block_on(GpuDevice::open(AdapterChoice::HardwareElseSoftware)).expect(
        "GPU tests need an adapter and never skip: install a Vulkan driver, \
         for example the package mesa-vulkan-drivers",
    )
}

fn on_gpu(gpu: &GpuDevice) -> Backend {
    Backend::Gpu {
        device: gpu.device.clone(),
        queue: gpu.queue.clone(),
    }
}

fn at(y: f64) -> Frame {
    Frame {
        position: DVec3::Y * y,
        ..Frame::IDENTITY
    }
}

/// Two limbs of different assets with a box between them, half a millimetre from each.
fn box_between(backend: Backend) -> Result<(World, [InstanceId; 2], BodyId)> {
    let mut world = World::new(backend)?.with_up(UpAxis::Z);
    world.set_gravity(DVec3::ZERO);
    let [a, b] = [
        world.add_avatar(limb(5, 8))?,
        world.add_avatar(limb(6, 10))?,
    ];
    let apart = APART + 5e-4;
    let limbs = [
        world.add_instance_at(a, &at(-apart))?,
        world.add_instance_at(b, &at(apart))?,
    ];
    let shape = Shape::Box {
        half_extents: [0.04, 0.03, 0.02],
    };
    let body = world.add_body(RigidBody::new("box", shape, 500.0)?.at(Frame {
        position: DVec3::X * 0.125,
        ..Frame::IDENTITY
    }))?;
    Ok((world, limbs, body))
}

/// The longest way between joints and handles of two states, m.
fn way(a: &State, b: &State) -> f64 {
    let frames = a.frames.iter().zip(&b.frames);
    let frames = frames.map(|(a, b)| a.position.distance(b.position));
    let handles = a.handles.iter().zip(&b.handles);
    let handles = handles.map(|(a, b)| a.distance(*b));
    frames.chain(handles).fold(0.0, f64::max)
}

/// A gradient on the device is right to 1e-4 of its length (`potential::gpu` tests that), and so is a Newton step, of
/// which here none is longer than 1 mm: 0.1 µm a step, so 2 µm in 20, and as much again for what contact makes of it.
const BOUND: f64 = 4e-6;

/// Spring bones swing on the host: their frames are the same bits, and the device poses the skin by them.
#[test]
fn spring_bones_swing_as_on_the_cpu() -> Result<()> {
    let (gpu, avatar) = (device(), springs::tailed());
    let mut worlds = Vec::new();
    for backend in [Backend::Cpu, on_gpu(&gpu)] {
        worlds.push(springs::world(&avatar, backend)?);
    }
    let (mut positions, mut normals) = (vec![Vec::new(); 2], Vec::new());
    for k in 0..20 {
        for ((world, key), positions) in worlds.iter_mut().zip(&mut positions) {
            (world.instance_mut(*key)?).set_spring_mode(SpringMode::All);
            springs::step(world, *key, &springs::shaken(&avatar, k))?;
            world.read_skin_blocking(*key, positions, &mut normals)?;
        }
        let frames = worlds
            .iter()
            .map(|(world, key)| Ok(world.instance(*key)?.frames()));
        let frames = frames.collect::<Result<Vec<_>>>()?;
        assert_eq!(frames[0], frames[1], "step {k}");
    }
    for v in avatar.tissue_vertices()..avatar.skin.len() {
        let off = positions[0][v].distance(positions[1][v]);
        // f32 of half a metre from the skin's origin.
        assert!(
            off < 4.0 * 0.5 * f64::from(f32::EPSILON),
            "vertex {v}: {off} m"
        );
    }
    Ok(())
}

#[test]
fn two_assets_and_a_body_are_in_step_with_the_cpu() -> Result<()> {
    let gpu = device();
    let (mut on_gpu, limbs, body) = box_between(on_gpu(&gpu))?;
    let (mut on_cpu, same, _) = box_between(Backend::Cpu)?;
    assert_eq!(limbs, same);
    let mut worst = 0.0f64;
    let mut before = Vec::new();
    for step in 1..=20 {
        let report = |limb: InstanceId| on_cpu.instance(limb).map(|limb| limb.report().clone());
        before = limbs.map(report).into_iter().collect::<Result<_>>()?;
        for world in [&mut on_gpu, &mut on_cpu] {
            for (limb, side) in limbs.into_iter().zip([-1.0, 1.0]) {
                let frame = at(side * (APART + 5e-4 - 1.5e-4 * f64::from(step)));
                world.instance_mut(limb)?.follow_frames(&[frame])?;
            }
            world.step_blocking(0.01)?;
        }
        for limb in limbs {
            let (on_gpu, on_cpu) = (on_gpu.instance(limb)?, on_cpu.instance(limb)?);
            worst = worst.max(way(on_gpu.state(), on_cpu.state()));
            assert_eq!(on_gpu.report().iterations, on_cpu.report().iterations);
        }
        let places = [on_gpu.body_frame(body)?, on_cpu.body_frame(body)?];
        worst = worst.max(places[0].position.distance(places[1].position));
    }
    // A report from the GPU is of the step before.
    for (limb, on_cpu) in limbs.into_iter().zip(before) {
        let on_gpu = on_gpu.instance(limb)?.report();
        assert!(on_cpu.contacts > 0, "nothing touched");
        assert_eq!(on_gpu.contacts, on_cpu.contacts);
        let error = (on_gpu.contact_force - on_cpu.contact_force).length();
        assert!(error < 0.01 * on_cpu.contact_force.length(), "{error} N");
    }
    println!("{worst:e} m");
    assert!(0.0 < worst && worst < BOUND, "{worst:e} m");
    Ok(())
}

#[test]
fn a_step_is_one_submission_and_one_readback_beside_the_skin() -> Result<()> {
    let gpu = device();
    let (world, limbs, _) = box_between(on_gpu(&gpu))?;
    let paper = Settings {
        integrator: Integrator::BackwardEuler,
        solver: SolverMode::OneIteration,
        report_at_end: true,
        ..Settings::default()
    };
    let mut world = world.with_settings(paper)?;
    let traffic = |world: &mut World| -> Result<[u64; 2]> {
        world.step_blocking(0.01)?;
        let before = world.traffic();
        for _ in 0..3 {
            world.step_blocking(0.01)?;
        }
        let after = world.traffic();
        for limb in limbs {
            assert_eq!(world.instance(limb)?.report().iterations, 1);
        }
        Ok([0, 1].map(|k| after[k] - before[k]))
    };
    assert_eq!(traffic(&mut world)?, [3 * 2, 3]);
    for limb in limbs {
        world.instance_mut(limb)?.ragdoll(0.0)?;
    }
    assert_eq!(traffic(&mut world)?, [3 * 2, 3]);
    // The default looks at E where the step leads, since something is near.
    let mut world = world.with_settings(Settings {
        report_at_end: true,
        ..Settings::default()
    })?;
    assert_eq!(traffic(&mut world)?, [3 * 3, 3 * 2]);
    Ok(())
}

#[test]
fn reports_come_with_the_next_step_but_the_first() -> Result<()> {
    let gpu = device();
    // Loads and energies of a limb whose bone goes up faster and faster, in each of five steps, then of one that stands
    // in its place.
    let run = |backend: Backend| -> Result<(Vec<[f64; 3]>, [u64; 2])> {
        let mut world = World::new(backend)?;
        let avatar = world.add_avatar(limb(5, 8))?;
        let first = world.add_instance(avatar)?;
        let told = |world: &World, limb| -> Result<[f64; 3]> {
            let report = world.instance(limb)?.report();
            let inertia = report.skeleton_energies.inertia + report.energies.inertia;
            Ok([report.loads[0].force.y, report.loads[0].torque.z, inertia])
        };
        let mut tale = Vec::new();
        for step in 0..5 {
            let up = 1e-4 * f64::from(step).powi(3);
            world.instance_mut(first)?.follow_frames(&[at(up)])?;
            world.step_blocking(0.01)?;
            tale.push(told(&world, first)?);
        }
        let before = world.traffic();
        world.remove_instance(first)?;
        let second = world.add_instance(avatar)?;
        world.step_blocking(0.01)?;
        tale.push(told(&world, second)?);
        let after = world.traffic();
        Ok((tale, [0, 1].map(|k| after[k] - before[k])))
    };
    let (on_gpu, traffic) = run(on_gpu(&gpu))?;
    let (on_cpu, _) = run(Backend::Cpu)?;
    // The second's own report is waited for.
    assert_eq!(traffic, [3, 2]);
    for (k, of) in [0, 0, 1, 2, 3, 5].into_iter().enumerate() {
        for (on_gpu, on_cpu) in on_gpu[k].iter().zip(on_cpu[of]) {
            // Forces of 50 N that jerks of metres a second squared make.
            assert!(
                (on_gpu - on_cpu).abs() < 1e-3 * (0.1 + on_cpu.abs()),
                "{k}: {on_gpu} for {on_cpu}"
            );
        }
    }
    let differ = |k: usize| (on_cpu[k][0] - on_cpu[k + 1][0]).abs() > 0.1;
    assert!(
        (0..4).all(differ),
        "{on_cpu:?} would not tell a step from the next"
    );
    Ok(())
}

#[test]
fn line_searches_of_many_end_where_those_on_the_cpu_end() -> Result<()> {
    let gpu = device();
    let converged = Settings {
        solver: SolverMode::Converged {
            tolerance: 1e-6,
            max_iterations: 20,
        },
        ..Settings::default()
    };
    let run = |backend: Backend| -> Result<(Vec<State>, [u64; 2])> {
        let mut world = World::new(backend)?.with_settings(converged)?;
        let mut keys = Vec::new();
        for (avatar, count) in [(limb(4, 6), 12), (limb(5, 6), 1)] {
            let avatar = world.add_avatar(avatar)?;
            for _ in 0..count {
                keys.push(world.add_instance_at(avatar, &at(keys.len() as f64))?);
            }
        }
        world.step_blocking(0.01)?;
        let before = world.traffic();
        for (i, &key) in keys.iter().enumerate() {
            let frame = at(i as f64 + 0.002 + 0.001 * i as f64);
            world.instance_mut(key)?.follow_frames(&[frame])?;
        }
        world.step_blocking(0.01)?;
        let after = world.traffic();
        let states = keys
            .iter()
            .map(|key| Ok(world.instance(*key)?.state().clone()));
        let states = states.collect::<Result<_>>()?;
        Ok((states, [0, 1].map(|k| after[k] - before[k])))
    };
    let (on_gpu, traffic) = run(on_gpu(&gpu))?;
    let (on_cpu, none) = run(Backend::Cpu)?;
    assert_eq!(none, [0, 0]);
    // An evaluation, a trial of each in two turns (of 8 with their bases), and the step's end at least.
    assert!(traffic[1] >= 4, "{traffic:?}");
    let errors = on_gpu.iter().zip(&on_cpu).map(|(a, b)| way(a, b));
    let worst = errors.fold(0.0, f64::max);
    println!("{worst:e} m, {traffic:?}");
    assert!(0.0 < worst && worst < BOUND, "{worst:e} m");
    Ok(())
}

#[test]
fn the_skin_is_where_it_is_drawn_from() -> Result<()> {
    let gpu = device();
    let (mut world, limbs, _) = box_between(on_gpu(&gpu))?;
    world.step_blocking(0.01)?;
    for limb in limbs {
        let (mut positions, mut normals) = (Vec::new(), Vec::new());
        world.read_skin_blocking(limb, &mut positions, &mut normals)?;
        let skin = world.skin_buffer(limb)?.expect("on the GPU");
        let size = skin.range.end - skin.range.start;
        assert_eq!(size, 32 * positions.len() as u64);
        assert_eq!(skin.range.start % 256, 0);
        let copy = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: None,
            size,
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(skin.buffer, skin.range.start, &copy, 0, size);
        gpu.queue.submit([encoder.finish()]);
        copy.map_async(wgpu::MapMode::Read, .., |mapped| mapped.unwrap());
        gpu.device
            .poll(wgpu::PollType::wait_indefinitely())
            .unwrap();
        let bytes = copy.get_mapped_range(..).unwrap();
        for (vertex, position) in bytes.chunks_exact(32).zip(&positions) {
            let drawn: [f32; 3] = bytemuck::pod_read_unaligned(&vertex[..12]);
            assert_eq!(skin.origin + Vec3::from_array(drawn).as_dvec3(), *position);
        }
    }
    let (on_cpu, limbs, _) = box_between(Backend::Cpu)?;
    assert!(on_cpu.skin_buffer(limbs[0])?.is_none());
    Ok(())
}

/// Instances' ranges begin where a host may bind them, whatever the number of vertices.
#[test]
fn the_skin_of_an_instance_may_be_bound_alone() -> Result<()> {
    let gpu = device();
    let (world, _, keys) = previous_skins::three(on_gpu(&gpu))?;
    let binding = wgpu::BindGroupLayoutEntry {
        binding: 0,
        visibility: wgpu::ShaderStages::VERTEX,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let layout = (gpu.device).create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[binding],
    });
    let mut ends = Vec::new();
    for key in keys {
        let skin = world.skin_buffer(key)?.expect("on the GPU");
        assert_eq!(skin.range.start % 256, 0, "{:?}", skin.range);
        ends.push(skin.range.end % 256);
        for buffer in [skin.buffer, skin.previous] {
            let bound = wgpu::BufferBinding {
                buffer,
                offset: skin.range.start,
                size: std::num::NonZero::new(skin.range.end - skin.range.start),
            };
            let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
            let _group = (gpu.device).create_bind_group(&wgpu::BindGroupDescriptor {
                label: None,
                layout: &layout,
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::Buffer(bound),
                }],
            });
            assert!(pollster::block_on(scope.pop()).is_none());
        }
    }
    // Or the second instance's would begin there by chance.
    assert_ne!(ends[0], 0);
    Ok(())
}

#[test]
fn the_previous_skin_is_that_of_the_step_before() -> Result<()> {
    let gpu = device();
    let (world, avatar, keys) = previous_skins::three(on_gpu(&gpu))?;
    previous_skins::check(world, avatar, keys)
}

#[test]
fn forces_on_vertices_add_up_to_the_report() -> Result<()> {
    let gpu = device();
    let rounding = f64::from(f32::EPSILON) / 2.0;
    // A force has some 10 roundings of its own, and one for each that is added before; here some tens touch.
    let sum_bound = 100.0 * rounding;
    // A place is some 20 roundings of 0.3 m off, in the skin and in the contacts.
    let depth_bound = 2.0 * 20.0 * rounding * 0.3;
    contacts::check(contacts::pressed(on_gpu(&gpu))?, sum_bound, depth_bound)
}

fn is_send<T: Send>(_: T) {}

#[test]
fn a_step_may_go_to_another_thread() -> Result<()> {
    let gpu = device();
    let (mut world, limbs, _) = box_between(on_gpu(&gpu))?;
    is_send(world.step(0.01));
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    is_send(world.read_skin(limbs[0], &mut positions, &mut normals));
    is_send(World::open(Backend::Auto));
    Ok(())
}
