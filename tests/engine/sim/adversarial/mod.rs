//! What no user should do: colliders that appear inside the body, targets that flip, springs and tissues of very
//! different stiffness, also side by side in one avatar, joints that are drawn beyond their limits, a rough body thrown
//! into the skin, time steps of any length in any order. Within stated bounds the avatar recovers; beyond them it stays
//! finite, or the step is refused and leaves everything as it was.

mod avatars;
mod storm;

use avatars::{AWAY, finger};
use std::ops::Range;
use std::sync::Arc;
use storm::{BEYOND, STATED, Severity, Storm, set_time_step};
use supple::Error;
use supple::glam::DVec3;
use supple::internal::cpu::min_det_f;
use supple::model::{Avatar, Integrator};
use supple::potential::{CpuPotential, Potential};
use supple::sim::{Settings, Simulation, SolverMode};
use supple::skeleton::{Spring, Tracking};

fn modes() -> [SolverMode; 3] {
    [
        SolverMode::OneIteration,
        SolverMode::BUDGETED,
        SolverMode::Converged {
            tolerance: 1e-6,
            max_iterations: 30,
        },
    ]
}

fn settings(solver: SolverMode) -> Settings {
    Settings {
        solver,
        // The paper's mode is of the paper's integrator.
        integrator: match solver {
            SolverMode::OneIteration => Integrator::BackwardEuler,
            _ => Integrator::Bdf2,
        },
        bending_stiffness: 0.5,
        ..Settings::default()
    }
}

fn cpu(avatar: &Arc<Avatar>, solver: SolverMode) -> Simulation<CpuPotential> {
    let potential = CpuPotential::new(avatar.clone(), 1).unwrap();
    Simulation::new(avatar, potential, settings(solver)).unwrap()
}

/// Two seconds of calm: nothing touches the finger, and its bones are drawn to where they were at first. What is left
/// of the storm: the skin's largest distance from rest (m), and the smallest det F.
fn calm<P: Potential>(simulation: &mut Simulation<P>) -> (f64, f64) {
    let rest = finger().rest_state();
    let instance = &mut simulation.instances_mut()[0];
    instance.colliders.retain(|c| c.body.is_some());
    for ball in rest.frames.len()..instance.state.frames.len() {
        instance.set_motion(ball, AWAY, DVec3::ZERO, DVec3::ZERO);
    }
    for limit in &mut instance.limits {
        // Weaker than what draws the bones: a stiff one between two bones that are half a turn off, one each way round,
        // keeps them there, a minimum of the energy.
        limit.stiffness = 1.0;
    }
    instance.gravity = DVec3::ZERO;
    // What swings on is no damage.
    instance.factors.damping = 10.0;
    for (bone, target) in instance.targets.iter_mut().enumerate() {
        let spring = |stiffness, damping| Some(Spring { stiffness, damping });
        *target = Tracking {
            rotation: spring(10.0, 0.1),
            position: spring(1e4, 10.0),
            ..Tracking::new(bone, rest.frames[bone])
        };
        instance.bending[bone].stiffness = 0.5;
    }
    set_time_step(simulation, 1.0 / 60.0);
    for _ in 0..120 {
        simulation.step_blocking().unwrap();
    }
    let (mut skin, mut normals) = (Vec::new(), Vec::new());
    simulation
        .read_skin_blocking(0, &mut skin, &mut normals)
        .unwrap();
    let pairs = skin.iter().zip(&finger().skin.position);
    let left = pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
    let state = &simulation.instances()[0].state;
    (left, min_det_f(finger(), state))
}

#[test]
fn it_recovers_within_two_seconds() {
    recovers(0..40, Storm::new);
}

#[test]
fn in_rough_company_it_recovers_too() {
    recovers(0..20, Storm::in_company);
}

fn recovers(seeds: Range<u64>, storm: fn(u64, &'static Severity) -> Storm) {
    let (mut failures, mut bite) = (Vec::new(), 0.0f64);
    for seed in seeds {
        for mode in modes() {
            let mut storm = storm(seed, &STATED);
            let mut simulation = cpu(&storm.avatar(), mode);
            storm.rage(&mut simulation, |step, outcome| {
                if let Err(error) = outcome {
                    panic!("seed {seed}, {mode:?}, step {step}: {error}");
                }
            });
            bite = bite.max(storm.bite);
            let (left, det_f) = calm(&mut simulation);
            if !(left < 1e-4 && det_f > 0.9) {
                failures.push(format!("seed {seed}, {mode:?}: {left:e} m, det F {det_f}"));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    println!("handles were displaced by up to {bite} m");
    assert!(bite > 0.01, "{bite} m is no storm");
}

#[test]
fn beyond_its_bounds_it_stays_finite_or_refuses() {
    survives(100..140, Storm::new);
}

#[test]
fn in_rough_company_it_stays_finite_or_refuses() {
    survives(100..120, Storm::in_company);
}

fn survives(seeds: Range<u64>, storm: fn(u64, &'static Severity) -> Storm) {
    let mut refused = 0;
    for seed in seeds {
        for mode in modes() {
            let mut storm = storm(seed, &BEYOND);
            let mut simulation = cpu(&storm.avatar(), mode);
            storm.rage(&mut simulation, |step, outcome| match outcome {
                Ok(()) => {}
                Err(Error::NotFinite { .. } | Error::Solve { .. }) => refused += 1,
                Err(error) => panic!("seed {seed}, {mode:?}, step {step}: {error}"),
            });
        }
    }
    println!("{refused} steps were refused");
}

#[cfg(feature = "gpu")]
#[test]
fn a_gpu_recovers_too_and_survives() {
    use supple::GpuError;
    use supple::gpu::{AdapterChoice, GpuDevice};
    use supple::potential::{GpuOptions, GpuPotential};
    let gpu = pollster::block_on(GpuDevice::open(AdapterChoice::HardwareElseSoftware)).expect(
        "GPU tests need an adapter and never skip: install a Vulkan driver, for example the package \
         mesa-vulkan-drivers",
    );
    let simulation = |avatar: &Arc<Avatar>| {
        let (device, queue) = (&gpu.device, &gpu.queue);
        let options = GpuOptions {
            contacts: 4 * avatar.skin.len(),
            ..GpuOptions::default()
        };
        let potential = GpuPotential::new(device, queue, avatar.clone(), 1, options).unwrap();
        Simulation::new(avatar, potential, settings(SolverMode::OneIteration)).unwrap()
    };
    for seed in 0..3 {
        let mut storm = Storm::new(seed, &STATED);
        let mut simulation = simulation(&storm.avatar());
        storm.rage(&mut simulation, |step, outcome| {
            if let Err(error) = outcome {
                panic!("seed {seed}, step {step}: {error}");
            }
        });
        let (left, det_f) = calm(&mut simulation);
        assert!(
            left < 1e-4 && det_f > 0.9,
            "seed {seed}: {left:e} m, {det_f}"
        );
    }
    for seed in 100..103 {
        let mut storm = Storm::new(seed, &BEYOND);
        let mut simulation = simulation(&storm.avatar());
        storm.rage(&mut simulation, |step, outcome| match outcome {
            Ok(()) | Err(Error::NotFinite { .. } | Error::Solve { .. }) => {}
            Err(Error::Gpu(GpuError::DeviceLost(problem))) => panic!("seed {seed}: {problem}"),
            Err(error) => panic!("seed {seed}, step {step}: {error}"),
        });
    }
}
