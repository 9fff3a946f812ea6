//! A step of a world: 1, 10 and 100 sample hands, each pressed on the cylinder of `hand_press` and pulled by springs at
//! the wrist, then with all their bones where the host has them. On the CPU, and on a GPU (a software adapter where there
//! is no other).

use criterion::{Criterion, criterion_group, criterion_main};
use std::sync::Arc;
use supple::collider::Collider;
use supple::gpu::{AdapterChoice, GpuDevice};
use supple::model::{Avatar, UpAxis};
use supple::potential::CpuPotential;
use supple::sim::{Instance, Simulation};
use supple::world::{Backend, InstanceId};
use supple::{Result, World};
use supple_bake::bake;
use supple_scene::{Driver, Scene, read_scene};

/// h of the scene, s.
const TIME_STEP: f64 = 0.01;

/// How much faster than in the scene the hands come down.
const HURRY: f64 = 4.0;

/// A hand at full press, and what presses it.
fn pressed(scene: &Scene, avatar: &Arc<Avatar>) -> Result<(Instance, Vec<Collider>)> {
    let mut driver = Driver::new(scene, avatar)?;
    let potential = CpuPotential::new(avatar.clone(), 1)?;
    let mut simulation = Simulation::new(avatar, potential, scene.settings)?;
    driver.start(avatar, &mut simulation.instances_mut()[0]);
    for step in 1..=scene.step_at(scene.measure.full_press / HURRY) {
        let time = HURRY * step as f64 * scene.settings.time_step;
        driver.drive(time, &mut simulation.instances_mut()[0])?;
        let report = simulation.step_blocking()?;
        let last = time > scene.measure.full_press - 0.1;
        assert!(
            !last || report.instances[0].contacts > 0,
            "it must be in contact"
        );
    }
    let mut hand = simulation.instances_mut()[0].clone();
    let colliders = std::mem::take(&mut hand.colliders);
    Ok((hand, colliders))
}

/// A world of `count` such hands.
fn world(
    (hand, colliders): &(Instance, Vec<Collider>),
    avatar: &Arc<Avatar>,
    backend: Backend,
    count: usize,
) -> Result<(World, Vec<InstanceId>)> {
    let mut world = World::new(backend)?.with_up(UpAxis::Z);
    let asset = world.add_avatar(avatar.clone())?;
    for collider in colliders {
        world.add_collider(collider.clone())?;
    }
    let add = |_| {
        let key = world.add_instance(asset)?;
        let character = world.instance_mut(key)?;
        character.ragdoll(0.0)?;
        *character.instance_mut() = hand.clone();
        Ok(key)
    };
    let keys = (0..count).map(add).collect::<Result<_>>()?;
    Ok((world, keys))
}

/// Times steps of worlds of so many hands on a backend called `name`.
fn steps(
    criterion: &mut Criterion,
    hand: &(Instance, Vec<Collider>),
    avatar: &Arc<Avatar>,
    (name, backend): (&str, Backend),
) -> Result<()> {
    for count in [1, 10, 100] {
        let (mut world, hands) = world(hand, avatar, backend.clone(), count)?;
        let title = format!("world/{name}/{count} hands");
        criterion.bench_function(&title, |b| b.iter(|| world.step_blocking(TIME_STEP)));
        for &hand in &hands {
            assert!(
                world.instance(hand)?.report().contacts > 0,
                "it must be in contact"
            );

            let hand = world.instance_mut(hand)?;
            let frames = hand.frames().to_vec();
            hand.follow_frames(&frames)?;
        }
        let title = format!("world/{name}/{count} hands that follow");
        criterion.bench_function(&title, |b| b.iter(|| world.step_blocking(TIME_STEP)));
    }
    Ok(())
}

fn bench(criterion: &mut Criterion) {
    let scene = read_scene("assets/scenes/hand_press.toml").expect("a committed scene");
    let (body, mut recipe) = scene.avatar.body().expect("the sample hand");
    recipe.cubature.points = Some(700);
    let avatar = Arc::new(bake(&body, &recipe, &mut |_| {}).expect("a bake").0);
    let gpu = pollster::block_on(GpuDevice::open(AdapterChoice::HardwareElseSoftware))
        .expect("an adapter");
    let hand = pressed(&scene, &avatar).expect("a press");
    let on_gpu = Backend::Gpu {
        device: gpu.device,
        queue: gpu.queue,
    };
    for backend in [("cpu", Backend::Cpu), (&*gpu.adapter.name, on_gpu)] {
        steps(criterion, &hand, &avatar, backend).expect("a world");
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = bench
}
criterion_main!(benches);
