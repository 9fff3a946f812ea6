//! A whole step under full press. The sample hand, pressed on its cylinder: the f64 evaluation, and a GPU (a software
//! adapter where there is no other), at 700 and 2,000 cubature points; and its full space. The sample body and the
//! bone press: the f64 evaluation.

use criterion::{Criterion, criterion_group, criterion_main};
use std::sync::Arc;
use supple::gpu::{AdapterChoice, GpuDevice};
use supple::model::Avatar;
use supple::potential::{CpuPotential, GpuOptions, GpuPotential, Potential};
use supple::sim::{Pin, Simulation};
use supple_bake::{FineRecipe, bake, full_space_simulation};
use supple_scene::{Driver, Scene, read_scene};

fn scene(name: &str) -> Scene {
    read_scene(format!("assets/scenes/{name}.toml")).expect("a committed scene")
}

/// Runs `scene` in `hurry` times fewer steps until full press, then times steps there, in the end with all bones pinned
/// where they are.
fn pressed(
    criterion: &mut Criterion,
    name: &str,
    scene: &Scene,
    avatar: &Avatar,
    mut simulation: Simulation<impl Potential>,
    hurry: f64,
) -> supple::Result<()> {
    let mut driver = Driver::new(scene, avatar)?;
    driver.start(avatar, &mut simulation.instances_mut()[0]);
    let mut contacts = 0;
    for step in 1..=scene.step_at(scene.measure.full_press / hurry) {
        let time = hurry * step as f64 * scene.settings.time_step;
        driver.drive(time, &mut simulation.instances_mut()[0])?;
        contacts = simulation.step_blocking()?.instances[0].contacts;
    }
    assert!(contacts > 0, "it must be in contact");
    let name = format!("{name}, {} contacts", contacts);
    criterion.bench_function(&name, |b| b.iter(|| simulation.step_blocking()));
    let instance = &mut simulation.instances_mut()[0];
    instance.targets.clear();
    let frames = instance.state.frames.iter().copied().enumerate();
    instance.pins = frames.map(|(bone, frame)| Pin { bone, frame }).collect();
    let name = format!("{name}, all bones pinned");
    criterion.bench_function(&name, |b| b.iter(|| simulation.step_blocking()));
    Ok(())
}

/// The f64 evaluation alone, with fine handles as well: none awake, and 30.
fn on_cpu(criterion: &mut Criterion, name: &str, points: Option<usize>) -> supple::Result<()> {
    let scene = scene(name);
    let (body, mut recipe) = scene.avatar.body()?;
    recipe.cubature.points = points.or(recipe.cubature.points);
    recipe.fine_handles = Some(FineRecipe::default());
    let baked = bake(&body, &recipe, &mut |_| {})?.0;
    for fine in [0, 30] {
        let avatar = Arc::new(baked.clone().with_fine_slots(fine)?);
        let cpu = CpuPotential::new(avatar.clone(), 1)?;
        let cpu = Simulation::new(&avatar, cpu, scene.settings)?;
        let points = avatar.cubature.len();
        let name = format!("step/cpu/{name}, {points} points, {fine} fine handles awake");
        pressed(criterion, &name, &scene, &avatar, cpu, 4.0)?;
    }
    Ok(())
}

fn bench(criterion: &mut Criterion) {
    for (scene, points) in [
        ("chest_press", Some(500)),
        ("chest_press", Some(1400)),
        ("bone_press_m_82", None),
    ] {
        on_cpu(criterion, scene, points).expect("a press");
    }
    let gpu = pollster::block_on(GpuDevice::open(AdapterChoice::HardwareElseSoftware))
        .expect("an adapter");
    let scene = scene("hand_press");
    let (body, mut recipe) = scene.avatar.body().expect("the sample hand");
    for points in [700, 2000] {
        recipe.cubature.points = Some(points);
        let avatar = Arc::new(bake(&body, &recipe, &mut |_| {}).expect("a bake").0);
        let cpu = CpuPotential::new(avatar.clone(), 1).expect("the f64 evaluation");
        let cpu = Simulation::new(&avatar, cpu, scene.settings).expect("a simulation");
        let name = format!("step/cpu/{points} points");
        pressed(criterion, &name, &scene, &avatar, cpu, 4.0).expect("a press");
        let kernels = GpuPotential::new(
            &gpu.device,
            &gpu.queue,
            avatar.clone(),
            1,
            GpuOptions::default(),
        )
        .expect("kernels");
        let name = format!("step/{}/{points} points", gpu.adapter.name);
        let kernels = Simulation::new(&avatar, kernels, scene.settings).expect("a simulation");
        pressed(criterion, &name, &scene, &avatar, kernels, 4.0).expect("a press");
    }
    // Seconds a step: fewer of them, and a hastier press.
    let avatar = bake(&body, &recipe, &mut |_| {}).expect("a bake").0;
    let (full, simulation) =
        full_space_simulation(&avatar, 1, scene.settings).expect("the full space");
    let name = "step/cpu/full space";
    pressed(criterion, name, &scene, &full, simulation, 20.0).expect("a press");
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(10);
    targets = bench
}
criterion_main!(benches);
