//! A step works in the memory of the steps before it.

#[path = "engine/support.rs"]
mod support;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use supple::collider::{Collider, Shape};
use supple::glam::{DMat3, DVec3};
use supple::internal::math::in_pool;
use supple::model::{Avatar, Frame, RigidBody, SpringCollider, SpringJoint, UpAxis};
use supple::potential::CpuPotential;
use supple::sim::{Pin, Settings, Simulation, SpringMode, StepReport};
use supple::world::Backend;
use supple::{Result, World};
use supple_bake::{FineRecipe, HandleRegion, Recipe, bake};
use supple_samples::Limb;
use supple_scene::{Driver, read_scene};

/// The system's allocator, counting what all threads ask of it.
struct Counting;

static REQUESTS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every request goes to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        REQUESTS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise is handed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, place: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is handed on.
        unsafe { System.dealloc(place, layout) }
    }

    unsafe fn realloc(&self, place: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        REQUESTS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's promise is handed on.
        unsafe { System.realloc(place, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Steps of the slide that may still make room for more contacts than before, and those that may not.
const WARM_UP: usize = 80;
const STEPS: usize = 110;
/// From then on the root is pinned where it is, which may take memory once.
const PINNED: usize = 90;

/// A finger with a tracked root is drawn over a rough cylinder: targets, limits, contact and friction all have their
/// part. The only test of its binary, as another thread's requests would count. All steps are called in the pool: the
/// queue by which one from outside gets there takes memory for every 63 of them.
#[test]
fn a_warm_step_of_one_iteration_allocates_nothing() -> Result<()> {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/assets/scenes/finger_slide.toml"
    );
    let scene = read_scene(path)?;
    let (body, recipe) = scene.avatar.body()?;
    let avatar = Arc::new(bake(&body, &recipe, &mut |_| {})?.0);
    let potential = CpuPotential::new(avatar.clone(), 1)?;
    let mut simulation = Simulation::new(&avatar, potential, scene.settings)?;
    let mut driver = Driver::new(&scene, &avatar)?;
    driver.start(&avatar, &mut simulation.instances_mut()[0]);
    let mut report = StepReport::default();
    let (mut requests, mut slid) = ([0; STEPS], false);
    in_pool(|| {
        pollster::block_on(async {
            for (step, count) in (1..).zip(&mut requests) {
                let time = step as f64 * scene.settings.time_step;
                let instance = &mut simulation.instances_mut()[0];
                if step as usize <= PINNED {
                    driver.drive(time, instance)?;
                } else {
                    instance.targets.clear();
                    instance.pins.clear();
                    let frame = instance.state.frames[0];
                    instance.pins.push(Pin { bone: 0, frame });
                }
                let before = REQUESTS.load(Ordering::Relaxed);
                simulation.step_into(&mut report).await?;
                *count = REQUESTS.load(Ordering::Relaxed) - before;
                slid |= step as usize > WARM_UP && report.instances[0].energies.friction != 0.0;
            }
            Ok::<_, supple::Error>(())
        })
    })?;
    assert!(slid && !report.instances[0].loads.is_empty());
    assert!(requests[0] > 0, "the allocator does not count");
    requests[PINNED] = 0;
    assert_eq!(requests[WARM_UP..], [0; STEPS - WARM_UP], "{requests:?}");
    following_a_host_allocates_nothing(&avatar, &simulation.instances()[0].state.frames)?;
    a_warm_step_of_a_world_allocates_nothing(avatar)?;
    waking_allocates_nothing()?;
    spring_bones_allocate_nothing()
}

/// A sphere is pushed into a limb and out again, the same way twice: fine handles wake, fade and sleep.
fn waking_allocates_nothing() -> Result<()> {
    const CYCLE: usize = 110;
    let recipe = Recipe {
        handles: vec![HandleRegion {
            count: Some(30),
            ..HandleRegion::default()
        }],
        fine_handles: Some(FineRecipe::default()),
        ..Recipe::default()
    };
    let avatar = bake(&Limb::S.body()?, &recipe, &mut |_| {})?.0;
    let avatar = Arc::new(avatar.with_fine_slots(15)?);
    let potential = CpuPotential::new(avatar.clone(), 1)?;
    let mut simulation = Simulation::new(&avatar, potential, Settings::default())?;
    let instance = &mut simulation.instances_mut()[0];
    let frame = instance.state.frames[0];
    instance.pins.push(Pin { bone: 0, frame });
    let at = |step: usize| {
        let turn = step as f64 / CYCLE as f64 * std::f64::consts::TAU;
        DVec3::new(0.125, 0.0, 0.095 + 0.04 * turn.cos())
    };
    let mut sphere = Collider::new(Shape::Sphere { radius: 0.02 }, Frame::IDENTITY);
    sphere.frame.position = at(0);
    sphere.previous = sphere.frame;
    instance.colliders.push(sphere);
    let mut report = StepReport::default();
    let (mut requests, mut awake) = ([0; 3 * CYCLE], [0; 3 * CYCLE]);
    in_pool(|| {
        pollster::block_on(async {
            for (step, count) in requests.iter_mut().enumerate() {
                let instance = &mut simulation.instances_mut()[0];
                instance.colliders[0].frame.position = at(step);
                let before = REQUESTS.load(Ordering::Relaxed);
                simulation.step_into(&mut report).await?;
                *count = REQUESTS.load(Ordering::Relaxed) - before;
                awake[step] = simulation.instances()[0].awake.handles().len();
            }
            Ok::<_, supple::Error>(())
        })
    })?;
    let last = &awake[2 * CYCLE..];
    assert!(last.contains(&0) && last.contains(&15), "{awake:?}");
    assert_eq!(requests[2 * CYCLE..], [0; CYCLE], "{requests:?}");
    Ok(())
}

/// Hair on a root that a host moves, near a collider, in steps of one substep and of several.
fn spring_bones_allocate_nothing() -> Result<()> {
    let hair = SpringJoint {
        stiffness: 0.5,
        drag_force: 0.2,
        hit_radius: 0.01,
        ..support::LIMP
    };
    let limb = support::full_space_limb(&support::SMALL, 1, true);
    let mut avatar = support::with_tail(&limb, 6, hair);
    avatar.springs.colliders.push(SpringCollider {
        bone: 0,
        offset: DVec3::new(-0.4, 0.0, -0.05),
        tail: None,
        radius: 0.03,
    });
    avatar.springs.chains[0].colliders.push(0);
    let mut frames = avatar.rest_state().frames;
    let mut world = World::new(Backend::Cpu)?.with_up(UpAxis::Z);
    let key = world.add_avatar(avatar)?;
    let key = world.add_instance(key)?;
    (world.instance_mut(key)?).set_spring_mode(SpringMode::All);
    world.add_ground()?;
    let mut requests = [0; 40];
    in_pool(|| {
        for (step, count) in requests.iter_mut().enumerate() {
            let before = REQUESTS.load(Ordering::Relaxed);
            for frame in &mut frames {
                frame.position.z = 0.1 * (step as f64).sin();
            }
            world.instance_mut(key)?.follow_frames(&frames)?;
            world.step_blocking(if step % 2 == 0 { 0.01 } else { 0.05 })?;
            *count = REQUESTS.load(Ordering::Relaxed) - before;
        }
        Ok::<_, supple::Error>(())
    })?;
    assert!(requests[0] > 0);
    assert_eq!(requests[20..], [0; 20], "{requests:?}");
    Ok(())
}

/// From frames to a host's matrices and back, by world and by skinning matrices, in vectors that have room.
fn following_a_host_allocates_nothing(avatar: &Avatar, posed: &[Frame]) -> Result<()> {
    let (list, skeleton) = (&avatar.joints, &avatar.skeleton);
    let (mut world, mut skinning, mut frames) = (Vec::new(), Vec::new(), Vec::new());
    let mut requests = [0; 2];
    for count in &mut requests {
        let before = REQUESTS.load(Ordering::Relaxed);
        list.joint_matrices(posed, &mut world)?;
        list.skinning_matrices(0, posed, &mut skinning)?;
        list.frames_from_skinning(skeleton, 0, &skinning, &mut frames)?;
        list.frames_from_world(skeleton, &world, &mut frames)?;
        *count = REQUESTS.load(Ordering::Relaxed) - before;
    }
    assert!(requests[0] > 0 && requests[1] == 0, "{requests:?}");
    Ok(())
}

/// Two fingers with a box squeezed between them, which shares a linear system with both; one follows a host's matrices and
/// has offsets that change.
fn a_warm_step_of_a_world_allocates_nothing(avatar: Arc<Avatar>) -> Result<()> {
    let top = avatar.skin.position.iter().copied();
    let top = top.fold(DVec3::NEG_INFINITY, |a, b| if b.z > a.z { b } else { a });
    let mut world = World::new(Backend::Cpu)?.with_up(UpAxis::Z);
    world.set_gravity(DVec3::ZERO);
    let mut offsets = vec![[0.0; 3]; avatar.offset_vertices()];
    let key = world.add_avatar(avatar)?;
    let half = 0.01;
    let place = |turn: f64| {
        let rotation = DMat3::from_rotation_x(turn);
        let outward = rotation * DVec3::Z;
        Frame {
            rotation,
            position: -(rotation * top) - (half - 0.001) * outward,
        }
    };
    let fingers = [
        world.add_instance_at(key, &place(0.0))?,
        world.add_instance_at(key, &place(std::f64::consts::PI))?,
    ];
    let solid = Shape::Box {
        half_extents: [half; 3],
    };
    world.add_body(RigidBody::new("box", solid, 500.0)?)?;
    world.add_collider(Collider::new(
        Shape::HalfSpace,
        Frame {
            position: -DVec3::Z,
            ..Frame::IDENTITY
        },
    ))?;
    let mut matrices = Vec::new();
    world.instance(fingers[0])?.joint_matrices(&mut matrices)?;
    let (mut requests, mut touched) = ([0; 60], 0);
    in_pool(|| {
        for (step, count) in requests.iter_mut().enumerate() {
            let before = REQUESTS.load(Ordering::Relaxed);
            world.instance_mut(fingers[0])?.follow_world(&matrices)?;
            offsets[step % 7][2] = 1e-5 * step as f32;
            (world.instance_mut(fingers[0])?).set_pose_offsets(&offsets)?;
            world.step_blocking(0.01)?;
            *count = REQUESTS.load(Ordering::Relaxed) - before;
            let contacts =
                |&finger| Ok::<_, supple::Error>(world.instance(finger)?.report().contacts);
            touched +=
                usize::from(step > 40 && contacts(&fingers[0])? > 0 && contacts(&fingers[1])? > 0);
        }
        Ok::<_, supple::Error>(())
    })?;
    assert!(
        requests[0] > 0 && touched > 10,
        "{touched} steps with both in touch"
    );
    assert_eq!(requests[40..], [0; 20], "{requests:?}");
    Ok(())
}
