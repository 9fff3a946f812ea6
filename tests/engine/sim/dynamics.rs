//! What must hold of motion: momentum, energy, order of convergence, no preferred frame.

use crate::support;

use std::sync::Arc;
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::glam::{DMat3, DVec3};
use supple::internal::cpu::mechanics;
use supple::internal::math::rotation_exp;
use supple::model::{Avatar, Frame, Integrator, State};
use supple::potential::CpuPotential;
use supple::sim::{Pin, Settings, Simulation, SolverMode, Stop};
use supple::skeleton::{Preload, Spring, Tracking};
use supple_samples::Limb;

const CONVERGED: SolverMode = SolverMode::Converged {
    tolerance: 1e-10,
    max_iterations: 100,
};

fn simulation(avatar: &Avatar, settings: Settings) -> Simulation<CpuPotential> {
    let potential = CpuPotential::new(Arc::new(avatar.clone()), 1).unwrap();
    Simulation::new(avatar, potential, settings).unwrap()
}

/// The state a step of `time_step` earlier of a body that moves rigidly with velocity `v` and spins
/// with `w` about the origin.
fn earlier(state: &State, v: DVec3, w: DVec3, time_step: f64) -> State {
    let back = rotation_exp(-w * time_step);
    let frames = state.frames.iter().map(|f| Frame {
        rotation: back * f.rotation,
        position: back * f.position - v * time_step,
    });
    State {
        frames: frames.collect(),
        handles: state.handles.clone(),
        awake: state.awake.clone(),
    }
}

#[test]
fn free_flight_keeps_linear_momentum() -> Result<()> {
    let avatar = support::full_space_limb(&support::SMALL, 3, true);
    for solver in [CONVERGED, SolverMode::OneIteration] {
        let settings = Settings {
            solver,
            ..Settings::default()
        };
        let mut simulation = simulation(&avatar, settings);
        let instance = &mut simulation.instances_mut()[0];
        instance.gravity = DVec3::ZERO;
        let spin = DVec3::new(2.0, 6.0, 7.5);
        assert!((spin.length() - 10.0).abs() < 0.2);
        let previous = earlier(&instance.state, DVec3::new(0.5, -0.3, 1.0), spin, 1e-4);
        (instance.history).set_previous(&previous, &instance.state, 1e-4);
        let momentum = |simulation: &Simulation<CpuPotential>| {
            let instance = &simulation.instances()[0];
            let (before, after) = (instance.history.previous(), &instance.state);
            let time_step = instance.history.last_step();
            mechanics(&avatar, before, after, time_step, DVec3::ZERO).momentum
        };
        let start = momentum(&simulation);
        let mut drift: f64 = 0.0;
        for _ in 0..20 {
            simulation.step_blocking()?;
            drift = drift.max((momentum(&simulation) - start).length() / start.length());
        }
        println!("{solver:?}: momentum drifts by {drift:e} of itself in 20 steps");
        let bound = match solver {
            // Positions to 1e-10 m against 0.01 m a step.
            SolverMode::Converged { .. } => 1e-7,
            _ => 0.02,
        };
        assert!(drift < bound, "{solver:?}: {drift:e}");
    }
    Ok(())
}

/// What the potential says of its inertia and gravity is what the states say, to rounding.
fn agree(potential: f64, states: f64, scale: f64) {
    let error = (potential - states).abs();
    assert!(error <= 1e-10 * scale, "{potential} J and {states} J");
}

#[test]
fn energy_never_rises() -> Result<()> {
    let limb = Limb {
        stations: 4,
        layers: 1,
        sectors: 4,
        ..support::SMALL
    };
    let avatar = support::full_space_limb(&limb, 2, false);
    let settings = Settings {
        solver: SolverMode::Converged {
            tolerance: 1e-8,
            max_iterations: 100,
        },
        integrator: Integrator::BackwardEuler,
        joint_damping_time: 0.0,
        ..Settings::default()
    };
    let mut simulation = simulation(&avatar, settings);
    let instance = &mut simulation.instances_mut()[0];
    instance.preload = Preload::Off;
    instance.targets = vec![Tracking::new(0, instance.state.frames[0])];
    let floor = Frame {
        position: DVec3::new(0.0, 0.0, -0.05),
        ..Frame::IDENTITY
    };
    let floor = Collider::new(Shape::HalfSpace, floor);
    instance.colliders.push(floor);
    // Both the second bone and its tissue start in swing.
    let w = DVec3::new(0.0, 8.0, 3.0);
    let mut previous = instance.state.clone();
    previous.frames[1].rotation = rotation_exp(-w * 0.01);
    (instance.history).set_previous(&previous, &instance.state, 0.01);
    let mut total: Option<f64> = None;
    let (mut highest, mut kinetic) = (f64::MIN, Vec::new());
    let (mut start, mut touched) = (0.0, 0);
    for _ in 0..1000 {
        let report = simulation.step_blocking()?;
        assert_ne!(report.instances[0].stop, Stop::IterationLimit);
        touched += report.instances[0].contacts;
        let balance = pollster::block_on(simulation.energy_balance())?[0];
        let instance = &simulation.instances()[0];
        let of = |before, after| mechanics(&avatar, before, after, 0.01, instance.gravity);
        let previous = instance.history.previous();
        let now = of(previous, &instance.state);
        let before = of(previous, previous);
        let potential = match total {
            None => {
                start = balance.kinetic;
                0.0
            }
            Some(before) => before + balance.potential_change(),
        };
        total = Some(potential);
        agree(balance.kinetic, now.kinetic, start);
        agree(balance.gravity, now.gravity - before.gravity, start);
        highest = f64::max(highest, potential + balance.kinetic);
        kinetic.push(balance.kinetic);
    }
    assert!(touched > 0, "the ground is missed");
    println!(
        "started with {start} J, highest {highest} J, at the end {} J in motion",
        kinetic[999]
    );
    assert!(
        start > 1e-3 && highest < 1.01 * start,
        "{start} J → {highest} J"
    );
    assert!(kinetic[999] < 1e-9 * start, "it comes to rest");
    Ok(())
}

#[test]
fn refining_the_time_step_converges_at_first_order() -> Result<()> {
    let limb = Limb {
        stations: 4,
        layers: 1,
        sectors: 4,
        ..support::SMALL
    };
    let mut avatar = support::full_space_limb(&limb, 2, true);
    // Backward Euler damps a vibration by exp(−ω² h T/2): first order shows where that is near 1, so
    // the tissue damps its own fast ones.
    avatar.set_damping_time(4e-3);
    let duration = 0.02;
    let run = |steps: usize| -> Result<Vec<DVec3>> {
        let time_step = duration / steps as f64;
        let settings = Settings {
            time_step,
            solver: CONVERGED,
            integrator: Integrator::BackwardEuler,
            // Soft enough for every vibration to be resolved.
            joint_stiffness: 2e3,
            limit_stiffness: 0.0,
            bending_stiffness: 1.0,
            ..Settings::default()
        };
        let mut simulation = simulation(&avatar, settings);
        let instance = &mut simulation.instances_mut()[0];
        let spin = DVec3::new(0.0, 3.0, 1.0);
        let previous = earlier(&instance.state, DVec3::ZERO, spin, time_step);
        (instance.history).set_previous(&previous, &instance.state, time_step);
        for _ in 0..steps {
            simulation.step_blocking()?;
        }
        let state = &simulation.instances()[0].state;
        Ok(support::posed(&avatar, &avatar.skin, state))
    };
    let exact = run(640)?;
    let errors = [20, 40, 80].map(|n| support::largest_distance(&run(n).unwrap(), &exact));
    println!("errors at h = 1, ½, ¼ ms: {errors:?} m");
    // Against a reference at h/32 the ratios of first order are (1 − 1/32)/(½ − 1/32) = 2.07 and 2.14.
    for pair in errors.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((1.95..2.3).contains(&ratio), "{errors:?}");
    }
    Ok(())
}

/// Pins and damped targets that move at a constant velocity carry the limb along at that velocity.
#[test]
fn bones_follow_moving_pins_and_targets() -> Result<()> {
    let limb = Limb {
        stations: 4,
        layers: 1,
        sectors: 4,
        ..support::SMALL
    };
    let mut avatar = support::full_space_limb(&limb, 2, true);
    // So that it swings no more after two seconds.
    avatar.set_damping_time(0.02);
    let velocity = DVec3::new(0.3, -0.5, 0.2);
    let spring = |damping| {
        Some(Spring {
            stiffness: 0.0,
            damping,
        })
    };
    for (pinned, integrator, bound) in [
        (true, Integrator::BackwardEuler, 1e-6),
        (false, Integrator::BackwardEuler, 1e-6),
        // The joints' springs, which nothing damps, still swing a little.
        (true, Integrator::Bdf2, 1e-4),
        (false, Integrator::Bdf2, 1e-4),
    ] {
        let settings = Settings {
            integrator,
            ..Settings::default()
        };
        let mut simulation = simulation(&avatar, settings);
        let instance = &mut simulation.instances_mut()[0];
        instance.gravity = DVec3::ZERO;
        let start = instance.state.frames[0];
        if pinned {
            instance.pins = vec![Pin {
                bone: 0,
                frame: start,
            }];
        } else {
            instance.targets = vec![Tracking {
                rotation: spring(100.0),
                position: spring(1e4),
                ..Tracking::new(0, start)
            }];
        }
        for step in 1..=200 {
            let instance = &mut simulation.instances_mut()[0];
            let frame = Frame {
                position: start.position + velocity * (0.01 * step as f64),
                ..start
            };
            instance.pins.iter_mut().for_each(|p| p.frame = frame);
            instance.targets.iter_mut().for_each(|t| t.frame = frame);
            simulation.step_blocking()?;
            let instance = &simulation.instances()[0];
            if pinned {
                assert_eq!(instance.state.frames[0], frame);
            } else {
                assert_eq!(instance.targets[0].previous, frame);
            }
        }
        let instance = &simulation.instances()[0];
        let (before, after) = (&instance.history.previous().frames, &instance.state.frames);
        for (before, after) in before.iter().zip(after) {
            let slip = (after.position - before.position) / 0.01 - velocity;
            assert!(
                slip.length() < bound,
                "pinned {pinned}, {integrator:?}: {slip} m/s"
            );
        }
    }
    Ok(())
}

/// A swinging, tracked and pressed limb, moved as a whole by `placement`.
fn scene(placement: &Frame, solver: SolverMode) -> Result<(Avatar, State)> {
    let avatar = support::full_space_limb(&support::SMALL, 3, false);
    let settings = Settings {
        solver,
        ..Settings::default()
    };
    let mut simulation = simulation(&avatar, settings);
    let place = |f: &Frame| Frame {
        rotation: placement.rotation * f.rotation,
        position: placement.transform(f.position),
    };
    let spin = DVec3::new(3.0, -4.0, 0.0);
    let start = avatar.rest_state();
    let back = earlier(&start, DVec3::ZERO, spin, 0.01);
    let placed = |state: &State| State {
        frames: state.frames.iter().map(place).collect(),
        handles: state.handles.clone(),
        awake: state.awake.clone(),
    };
    let sphere = |z: f64| Frame {
        position: DVec3::new(0.12, 0.01, z),
        rotation: DMat3::IDENTITY,
    };
    let instance = &mut simulation.instances_mut()[0];
    instance.state = placed(&start);
    (instance.history).set_previous(&placed(&back), &instance.state, 0.01);
    instance.gravity = placement.rotation * DVec3::new(0.0, 0.0, -9.81);
    let mut target = Tracking::new(0, place(&start.frames[0]));
    target.rotation = Some(Spring {
        stiffness: 50.0,
        damping: 0.1,
    });
    instance.targets.push(target);
    let ball = Shape::Sphere { radius: 0.03 };
    let ball = Collider::new(ball, place(&sphere(0.07)));
    instance.colliders.push(ball);
    let mut touched = 0;
    for step in 1..=15 {
        let instance = &mut simulation.instances_mut()[0];
        instance.colliders[0].frame = place(&sphere(0.07 - 0.0005 * step as f64));
        touched += simulation.step_blocking()?.instances[0].contacts;
    }
    assert!(touched > 0, "the sphere misses");
    Ok((avatar, simulation.instances()[0].state.clone()))
}

#[test]
fn a_moved_scene_gives_the_moved_result() -> Result<()> {
    let placement = Frame {
        rotation: rotation_exp(DVec3::new(0.7, -1.1, 0.4)),
        position: DVec3::new(3.0, -5.0, 2.0),
    };
    for solver in [SolverMode::OneIteration, CONVERGED] {
        let (avatar, here) = scene(&Frame::IDENTITY, solver)?;
        let (_, there) = scene(&placement, solver)?;
        let expected: Vec<_> = support::posed(&avatar, &avatar.skin, &here)
            .into_iter()
            .map(|x| placement.transform(x))
            .collect();
        let error =
            support::largest_distance(&support::posed(&avatar, &avatar.skin, &there), &expected);
        let rest = support::posed(&avatar, &avatar.skin, &avatar.rest_state());
        let moved = support::largest_distance(&support::posed(&avatar, &avatar.skin, &here), &rest);
        println!("{solver:?}: {error:e} m of {moved:e} m");
        // Rounding of world positions some metres away, through 15 steps; the iterated one also stops
        // within its tolerance.
        assert!(moved > 0.01 && error < 1e-9, "{solver:?}: {error:e} m");
    }
    Ok(())
}
