//! The GPU plays every committed scene as the CPU does: from a state in the thick of it, step by step. A scene's
//! test is called like the scene.

use super::RUNNER;
use std::sync::LazyLock;
use supple::glam::DVec3;
use supple::gpu::{AdapterChoice, GpuDevice};
use supple::model::Avatar;
use supple::potential::{CpuPotential, GpuOptions, GpuPotential, Potential};
use supple::sim::Simulation;
use supple_scene::{Driver, Scene};

/// How far apart the skins may be, m: a third of what is seen at arm's length, and the same as for the demo.
const TOLERANCE: f64 = 0.05e-3;

/// The CPU's steps before the GPU joins, at most.
const ALONE: usize = 170;

/// Steps that both make.
const TOGETHER: usize = 30;

static GPU: LazyLock<GpuDevice> = LazyLock::new(|| {
    pollster::block_on(GpuDevice::open(AdapterChoice::HardwareElseSoftware)).expect(
        "GPU tests need an adapter and never skip: install a Vulkan driver, for example the package \
         mesa-vulkan-drivers",
    )
});

/// One avatar that `potential` evaluates, driven by the scene.
struct Player<P: Potential> {
    simulation: Simulation<P>,
    driver: Driver,
    time_step: f64,
}

impl<P: Potential> Player<P> {
    fn new(scene: &Scene, avatar: &Avatar, potential: P) -> Self {
        let mut simulation = Simulation::new(avatar, potential, scene.settings).unwrap();
        let driver = Driver::new(scene, avatar).unwrap();
        driver.start(avatar, &mut simulation.instances_mut()[0]);
        Self {
            simulation,
            driver,
            time_step: scene.settings.time_step,
        }
    }

    fn step(&mut self, step: usize) -> usize {
        let instance = &mut self.simulation.instances_mut()[0];
        let time = step as f64 * self.time_step;
        self.driver.drive(time, instance).unwrap();
        let report = self.simulation.step_blocking().unwrap();
        report.instances[0].contacts
    }

    fn skin(&mut self) -> Vec<DVec3> {
        let (mut skin, mut normals) = (Vec::new(), Vec::new());
        self.simulation
            .read_skin_blocking(0, &mut skin, &mut normals)
            .unwrap();
        skin
    }
}

fn agree(name: &str) {
    let scene = RUNNER.scene(name).unwrap();
    let avatar = RUNNER.avatar_of(&scene).unwrap();
    let colliders = scene.collider_count();
    let reference = CpuPotential::new(avatar.clone(), 1).unwrap();
    let mut cpu = Player::new(&scene, &avatar, reference);
    let options = GpuOptions {
        colliders: colliders.max(1),
        ..GpuOptions::default()
    };
    let (device, queue) = (&GPU.device, &GPU.queue);
    let potential = GpuPotential::new(device, queue, avatar.clone(), 1, options).unwrap();
    let mut gpu = Player::new(&scene, &avatar, potential);

    let press = scene.step_at(scene.measure.full_press);
    let alone = press.saturating_sub(TOGETHER / 2).min(ALONE);
    for step in 1..=alone {
        cpu.step(step);
    }
    let joined = cpu.simulation.instances()[0].clone();
    gpu.simulation.instances_mut()[0] = joined;
    let (mut worst, mut contacts): (f64, usize) = (0.0, 0);
    for step in alone + 1..=alone + TOGETHER {
        contacts = contacts.max(cpu.step(step));
        gpu.step(step);
        let (a, b) = (cpu.skin(), gpu.skin());
        let apart = a.iter().zip(&b).map(|(a, b)| a.distance(*b));
        worst = apart.fold(worst, f64::max);
    }
    let last = alone + TOGETHER;
    println!("{worst:.1e} m apart at most until step {last}, {contacts} contacts");
    // Two backends that agree in every bit are one.
    assert!(worst > 0.0 && worst < TOLERANCE, "{worst:e} m");
}

/// A test for each scene, and one that none is forgotten.
macro_rules! scenes {
    ($($name:ident),* $(,)?) => {
        $(
            #[test]
            fn $name() {
                agree(stringify!($name));
            }
        )*

        #[test]
        fn every_scene_is_tested() {
            assert_eq!(RUNNER.scenes().unwrap(), [$(stringify!($name)),*]);
        }
    };
}

scenes![
    body_spin,
    body_walk,
    bone_press_m,
    bone_press_m_82,
    bone_press_s,
    chest_press,
    compression,
    finger_press,
    finger_slide,
    hand_press,
    lift,
    limb_cylinders,
    palm_cylinders,
    posed_contact,
    ragdolls,
];
