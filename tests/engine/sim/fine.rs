//! Fine handles in time: awake where something touches, asleep elsewhere, and no jump in between.

use std::sync::{Arc, LazyLock};
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::model::{Avatar, Frame, Integrator};
use supple::potential::CpuPotential;
use supple::sim::{Pin, Settings, Simulation, SolverMode};
use supple_bake::{FineRecipe, HandleRegion, Recipe, bake};
use supple_samples::Limb;

/// The bone press limb with 40 handles that do not know the sphere, and all other vertices as fine ones.
pub static LIMB: LazyLock<Avatar> = LazyLock::new(|| {
    let recipe = Recipe {
        handles: vec![HandleRegion {
            count: Some(40),
            ..HandleRegion::default()
        }],
        fine_handles: Some(FineRecipe {
            spacing: Some(8e-3),
            ..FineRecipe::default()
        }),
        ..Recipe::default()
    };
    bake(&Limb::S.body().unwrap(), &recipe, &mut |_| {})
        .unwrap()
        .0
});

pub const RADIUS: f64 = 0.02;

/// The limb's top is at z = 0.04: a sphere that is `depth` inside there.
pub fn sphere(depth: f64) -> Frame {
    Frame {
        position: DVec3::new(0.125, 0.0, 0.04 + RADIUS - depth),
        ..Frame::IDENTITY
    }
}

fn simulation(
    avatar: &Arc<Avatar>,
    instances: usize,
    settings: Settings,
) -> Simulation<CpuPotential> {
    let potential = CpuPotential::new(avatar.clone(), instances).unwrap();
    let mut simulation = Simulation::new(avatar, potential, settings).unwrap();
    for instance in simulation.instances_mut() {
        let frame = instance.state.frames[0];
        instance.pins.push(Pin { bone: 0, frame });
    }
    simulation
}

fn with_slots(slots: usize) -> Arc<Avatar> {
    Arc::new(LIMB.clone().with_fine_slots(slots).unwrap())
}

fn skin(simulation: &mut Simulation<CpuPotential>, instance: usize) -> Vec<DVec3> {
    let (mut skin, mut normals) = (Vec::new(), Vec::new());
    simulation
        .read_skin_blocking(instance, &mut skin, &mut normals)
        .unwrap();
    skin
}

pub fn apart(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| a.distance(*b))
        .fold(0.0, f64::max)
}

/// Down to `deepest` and back, a millimetre a step, then nothing for a while.
pub fn way(deepest: f64) -> Vec<f64> {
    let (first, steps) = (-0.06, ((deepest + 0.06) / 1e-3).round() as usize);
    let down = (0..=steps).map(|k| first + 1e-3 * k as f64);
    let up = (0..=steps).rev().map(|k| first + 1e-3 * k as f64);
    down.chain(std::iter::repeat_n(deepest, 20))
        .chain(up)
        .chain([-0.06; 60])
        .collect()
}

#[test]
fn they_wake_ahead_of_contact_and_sleep_again_without_a_jump() {
    // Where its weight loads the handles, those that are awake carry some, which is taken back before they sleep.
    for captured in [true, false] {
        wake_and_sleep(captured);
    }
}

fn wake_and_sleep(captured_under_gravity: bool) {
    const SLOTS: usize = 12;
    let avatar = Arc::new(Avatar {
        captured_under_gravity,
        ..Avatar::clone(&with_slots(SLOTS))
    });
    let mut simulation = simulation(&avatar, 1, Settings::default());
    let collider = Collider::new(Shape::Sphere { radius: RADIUS }, sphere(-0.06));
    simulation.instances_mut()[0].colliders.push(collider);
    let (mut woke, mut touched, mut most) = (None, None, 0);
    let (mut before, mut slept, mut jump) = (Vec::new(), 0, 0.0f64);
    let mut awake_before = 0;
    for (step, depth) in way(0.006).into_iter().enumerate() {
        simulation.instances_mut()[0].colliders[0].frame = sphere(depth);
        let report = simulation.step_blocking().unwrap();
        let instance = &simulation.instances()[0];
        let awake = instance.awake.handles().len();
        assert!(awake <= SLOTS);
        let first = avatar.coarse_handles();
        let asleep = &instance.state.handles[first + awake..];
        assert!(asleep.iter().all(|phi| *phi == DVec3::ZERO));
        woke = woke.or((awake > 0).then_some(step));
        touched = touched.or((report.instances[0].contacts > 0).then_some(step));
        most = most.max(awake);
        let now = skin(&mut simulation, 0);
        if awake < awake_before && touched.is_some() && depth < -0.02 {
            slept += 1;
            jump = jump.max(apart(&now, &before));
        }
        (before, awake_before) = (now, awake);
    }
    let (woke, touched) = (woke.unwrap(), touched.unwrap());
    assert!(woke + 5 < touched, "woke at {woke}, touched at {touched}");
    assert_eq!(most, SLOTS);
    let instance = &simulation.instances()[0];
    assert!(instance.awake.is_none(), "{:?}", instance.awake);
    assert!(slept > 0 && jump < 1.5e-4, "{slept}, {jump}");
    // Those that were awake were the nearest ones: all have been under the sphere or beside it.
    assert!(
        instance.state.handles[avatar.coarse_handles()..]
            .iter()
            .all(|p| *p == DVec3::ZERO)
    );
}

#[test]
fn a_limb_that_nothing_touches_moves_bit_for_bit_as_one_without_slots() {
    let mut runs = [0, 20].map(|slots| {
        let avatar = with_slots(slots);
        let mut simulation = simulation(&avatar, 1, Settings::default());
        let far = Collider::new(Shape::Sphere { radius: RADIUS }, sphere(-1.0));
        simulation.instances_mut()[0].colliders.push(far);
        for step in 0..20 {
            let pin = &mut simulation.instances_mut()[0].pins[0];
            pin.frame.position.y = 0.01 * (0.5 * f64::from(step)).sin();
            simulation.step_blocking().unwrap();
        }
        let skin = skin(&mut simulation, 0);
        (simulation.instances()[0].state.clone(), skin)
    });
    let coarse = runs[0].0.handles.len();
    assert_eq!(runs[1].0.handles.len(), coarse + 20);
    runs[1].0.handles.truncate(coarse);
    assert!(runs[0] == runs[1]);
    assert!(runs[0].0.handles.iter().any(|phi| phi.length() > 1e-5));
}

/// Pressed 12 mm deep: the force of the full space is about half of what coarse handles answer with.
#[test]
fn instances_have_their_own_and_a_press_is_softer_with_them() {
    let settings = Settings {
        time_step: 100.0,
        integrator: Integrator::BackwardEuler,
        solver: SolverMode::Converged {
            tolerance: 1e-6,
            max_iterations: 100,
        },
        ..Settings::default()
    };
    let run = |slots: usize| {
        let avatar = with_slots(slots);
        let mut simulation = simulation(&avatar, 2, settings);
        let mut forces = [0.0; 2];
        for depth in [-0.01, 0.0, 0.003, 0.006, 0.009, 0.012, 0.012] {
            for (i, instance) in simulation.instances_mut().iter_mut().enumerate() {
                let frame = if i == 0 { sphere(depth) } else { sphere(-1.0) };
                let sphere = Collider::new(Shape::Sphere { radius: RADIUS }, frame);
                instance.colliders = vec![sphere];
                instance.history.rest(&instance.state);
            }
            let report = simulation.step_blocking().unwrap();
            forces = [0, 1].map(|i| report.instances[i].contact_force.length());
        }
        let awake = [0, 1].map(|i| simulation.instances()[i].awake.handles().len());
        let skins = [0, 1].map(|i| skin(&mut simulation, i));
        (forces, awake, skins)
    };
    let (coarse, fine) = (run(0), run(30));
    assert_eq!((coarse.1, fine.1), ([0, 0], [30, 0]));
    assert!(
        fine.0[0] > 0.0 && fine.0[0] < 0.6 * coarse.0[0],
        "{:?} {:?}",
        fine.0,
        coarse.0
    );
    assert!(
        fine.2[1] == coarse.2[1],
        "the other instance is not touched"
    );
    assert!(apart(&fine.2[0], &coarse.2[0]) > 1e-3);
    // The same input, the same bits.
    let again = run(30);
    assert!(again.0 == fine.0 && again.2 == fine.2);
}
