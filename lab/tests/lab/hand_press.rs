//! The demo scene meets its bars, and the GPU plays it as the CPU does.

use std::path::Path;
use std::sync::{Arc, OnceLock};
use supple::glam::DVec3;
use supple::model::{Avatar, State};
use supple::potential::{CpuPotential, Potential};
use supple::sim::Simulation;
use supple_bake::bake;
use supple_pictures::picture_strip;
use supple_scene::{Scene, SceneRun, read_scene, run_scene};

/// The scene, its hand, and its run on the CPU with every state recorded.
fn demo() -> &'static (Scene, Arc<Avatar>, SceneRun) {
    static DEMO: OnceLock<(Scene, Arc<Avatar>, SceneRun)> = OnceLock::new();
    DEMO.get_or_init(|| {
        let mut scene = read_scene(Path::new(super::SCENES).join("hand_press.toml")).unwrap();
        scene.output.record_every = 1;
        let (body, recipe) = scene.avatar.body().unwrap();
        let avatar = Arc::new(bake(&body, &recipe, &mut |_| {}).unwrap().0);
        let potential = CpuPotential::new(avatar.clone(), 1).unwrap();
        let mut simulation = Simulation::new(&avatar, potential, scene.settings).unwrap();
        let run = run_scene(&scene, &avatar, &mut simulation, &mut |_| {}).unwrap();
        (scene, avatar, run)
    })
}

#[test]
fn the_demo_meets_its_bars() {
    let (scene, avatar, run) = demo();
    let r = &run.report;
    println!("{r:#?}");
    assert_eq!((r.handles, r.cubature_points, r.bones), (87, 700, 16));
    assert_eq!(r.dofs, 357);
    assert!(r.full_press_displacement_mm >= 3.0);
    assert!((5.0..=30.0).contains(&r.contact_force_n));
    assert!((r.load_n / r.contact_force_n - 1.0).abs() < 0.01);
    assert!(r.det_f() > 0.0);
    assert!(r.max_penetration_mm <= 1.0);
    assert!(r.max_joint_gap_mm <= 0.5);
    assert!(r.residual_displacement_mm <= 0.01);
    // The wrist's target goes 12 mm past first contact, to the 0.4 mm it moves in a step.
    let height = |t: f64| scene.targets[0].motion.at(t).position.z;
    let past = height(r.first_contact_s.unwrap()) - height(scene.measure.full_press);
    assert!((past - 0.012).abs() < 0.5e-3, "{past}");
    if let Some(folder) = std::env::var_os("SUPPLE_PICTURES") {
        let strip = picture_strip(scene, avatar, &run.snapshots);
        strip
            .write_png(&Path::new(&folder).join("hand_press.png"))
            .unwrap();
    }
}

/// The drawn skin of a state.
fn skin(reference: &mut CpuPotential, state: &State) -> Vec<DVec3> {
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    pollster::block_on(reference.pose_skin(std::slice::from_ref(state), &[], &[])).unwrap();
    pollster::block_on(reference.read_skin(0, &mut positions, &mut normals)).unwrap();
    positions
}

#[test]
fn gpu_and_cpu_agree_at_every_step() {
    use supple::gpu::{AdapterChoice, GpuDevice};
    use supple::potential::{GpuOptions, GpuPotential};
    const TOLERANCE: f64 = 0.05e-3;
    let (scene, avatar, cpu) = demo();
    let gpu = pollster::block_on(GpuDevice::open(AdapterChoice::HardwareElseSoftware)).expect(
        "GPU tests need an adapter and never skip: install a Vulkan driver, for example the package \
         mesa-vulkan-drivers",
    );
    let (device, queue) = (&gpu.device, &gpu.queue);
    let options = GpuOptions::default();
    let potential = GpuPotential::new(device, queue, avatar.clone(), 1, options).unwrap();
    let mut simulation = Simulation::new(avatar, potential, scene.settings).unwrap();
    let run = run_scene(scene, avatar, &mut simulation, &mut |_| {}).unwrap();
    let mut reference = CpuPotential::new(avatar.clone(), 1).unwrap();
    assert_eq!(run.recording.states.len(), scene.steps + 1);
    let mut worst: f64 = 0.0;
    for (step, (a, b)) in (cpu.recording.states.iter().zip(&run.recording.states)).enumerate() {
        let (a, b) = (skin(&mut reference, a), skin(&mut reference, b));
        let apart = a.iter().zip(&b).map(|(a, b)| (*a - *b).length());
        let apart = apart.fold(0.0, f64::max);
        assert!(apart < TOLERANCE, "step {step}: {apart} m apart");
        worst = worst.max(apart);
    }
    println!("{}: {:.2e} m apart at most", run.report.adapter, worst);
    assert!(worst > 0.0, "two backends that agree in every bit are one");
}
