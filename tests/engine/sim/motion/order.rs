//! Order of convergence, and what free motion keeps.

use super::{CONVERGED, simulation};
use crate::support;
use supple::Result;
use supple::collider::Shape;
use supple::glam::{DMat3, DVec3};
use supple::internal::math::{Random, rotation_exp};
use supple::material::{Material, StableNeoHookean};
use supple::model::{Avatar, Frame, RigidBody, State};
use supple::sim::{Settings, SolverMode};
use supple_samples::Limb;

const SMALLER: Limb = Limb {
    stations: 4,
    layers: 1,
    sectors: 4,
    ..support::SMALL
};

/// Steps of the reference, s.
const FINE: f64 = 0.02 / 1280.0;

/// A limb of two bones that is let fly and swing: where its skin is in the end. `lead` are its states at times that are
/// multiples of [`FINE`], up to where the run starts from its past.
fn run(avatar: &Avatar, lead: Option<&[State]>, steps: &[f64]) -> Result<Vec<DVec3>> {
    let states = states(avatar, lead, steps)?;
    Ok(support::posed(
        avatar,
        &avatar.skin,
        &states[states.len() - 1],
    ))
}

/// All states of it.
fn states(avatar: &Avatar, lead: Option<&[State]>, steps: &[f64]) -> Result<Vec<State>> {
    let settings = |time_step: f64| Settings {
        time_step,
        solver: CONVERGED,
        joint_stiffness: 2e3,
        limit_stiffness: 0.0,
        bending_stiffness: 1.0,
        ..Settings::default()
    };
    let mut simulation = simulation(avatar, settings(steps[0]));
    let instance = &mut simulation.instances_mut()[0];
    instance.gravity = DVec3::new(0.0, 0.0, -9.81);
    let rest = instance.state.clone();
    let at = |time: f64| State {
        frames: (rest.frames.iter())
            .map(|f| {
                let turn = rotation_exp(DVec3::new(0.0, 3.0, 1.0) * time);
                Frame {
                    rotation: turn * f.rotation,
                    position: turn * f.position + DVec3::new(0.2, 0.0, -0.1) * time,
                }
            })
            .collect(),
        handles: rest.handles.clone(),
        awake: Vec::new(),
    };
    match lead {
        None => (instance.history).set_previous(&at(-1e-6), &instance.state, 1e-6),
        Some(lead) => {
            let h = steps.iter().sum::<f64>() / steps.len() as f64;
            let apart = (h / FINE).round() as usize;
            let before = |k: usize| lead[lead.len() - 1 - k * apart].clone();
            instance.set_state(before(0));
            (instance.history).set_motion([before(1), before(2), before(3)], h);
        }
    }
    let mut states = vec![instance.state.clone()];
    for &time_step in steps {
        simulation.set_settings(settings(time_step))?;
        simulation.step_blocking()?;
        states.push(simulation.instances()[0].state.clone());
    }
    Ok(states)
}

/// `count` steps to 20 ms, all alike or each up to 30 % off.
fn steps(count: usize, random: bool) -> Vec<f64> {
    let mut random_of = Random::new(11);
    // The same irregular pattern whatever the count, so that halving all steps halves each.
    let pattern: Vec<f64> = (0..count)
        .map(|_| {
            if random {
                random_of.uniform(0.7, 1.3)
            } else {
                1.0
            }
        })
        .collect();
    let sum: f64 = pattern.iter().sum();
    pattern.into_iter().map(|p| 0.02 * p / sum).collect()
}

/// Each halving of h divides the error by at least 3.5 without damping, and by 3 with it, whose tangent is lagged.
#[test]
fn halving_the_time_step_quarters_the_error() -> Result<()> {
    let mut avatar = support::full_space_limb(&SMALLER, 2, true);
    for (damping_time, youngs_modulus, bound) in [(0.0, 300.0, 3.5), (4e-3, 3e4, 3.0)] {
        avatar.set_damping_time(damping_time);
        // Where nothing damps them, the fastest swings of the mesh must be slow enough for the steps.
        avatar.material = Material::StableNeoHookean(StableNeoHookean {
            youngs_modulus,
            poissons_ratio: 0.4,
        });
        // From (q⁰, v⁰) with v⁰ ≠ 0, and from the states that led to where the first run is after 2 ms.
        let all = states(&avatar, None, &steps(1280, false))?;
        let lead = &all[..=128];
        for lead in [None, Some(lead)] {
            let exact = run(&avatar, lead, &steps(1280, false))?;
            for random in [false, true] {
                let error = |count| -> Result<f64> {
                    let end = run(&avatar, lead, &steps(count, random))?;
                    Ok(support::largest_distance(&end, &exact))
                };
                let errors = [error(40)?, error(80)?, error(160)?];
                let past = lead.is_some();
                println!("β {damping_time}, past {past}, random {random}: {errors:?} m");
                // Random steps are other ones at each count: what is between two of them is noise of some 10 %.
                let bound = if random { 0.85 * bound } else { bound };
                assert!(errors[0] / errors[1] > bound, "{errors:?}");
                assert!(errors[1] / errors[2] > bound, "{errors:?}");
            }
        }
    }
    Ok(())
}

/// A box that spins about no principal axis: after a second at 60 Hz 97 % of its spin is left, within 1° of where it was,
/// from a velocity or with history, and its energy never rises by 1 %.
#[test]
fn a_thrown_box_spins_on() -> Result<()> {
    let shape = Shape::Box {
        half_extents: [0.03, 0.05, 0.08],
    };
    let place = DVec3::new(0.0, 0.0, 1.0);
    let at = Frame {
        position: place,
        ..Frame::IDENTITY
    };
    let body = RigidBody::new("box", shape, 800.0)?.at(at);
    let inertia = body.mass.second();
    let limb = support::full_space_limb(&SMALLER, 1, true);
    let avatar = limb.with_bodies(vec![body])?;
    let spin = 10.0 * DVec3::new(0.6, -0.3, 0.74).normalize();
    // L = Σ_k (R S)_k × Ṙ_k with Ṙ = [ω]× R, and K = ½ L · ω.
    let momentum = |rotation: DMat3, velocity: DMat3| -> DVec3 {
        let moved = rotation * inertia;
        (0..3).map(|k| moved.col(k).cross(velocity.col(k))).sum()
    };
    for history in [false, true] {
        let settings = Settings {
            time_step: 1.0 / 60.0,
            solver: SolverMode::BUDGETED,
            ..Settings::default()
        };
        let mut simulation = simulation(&avatar, settings);
        let instance = &mut simulation.instances_mut()[0];
        instance.gravity = DVec3::ZERO;
        instance.set_motion(1, at, DVec3::new(0.4, 1.0, 2.0), spin);
        let turning = DMat3::from_cols(
            spin.cross(DVec3::X),
            spin.cross(DVec3::Y),
            spin.cross(DVec3::Z),
        );
        let start = momentum(DMat3::IDENTITY, turning);
        if history {
            // From the first frames on.
            for _ in 0..3 {
                simulation.step_blocking()?;
            }
        }
        let now = |simulation: &supple::sim::Simulation<_>| {
            let instance: &supple::sim::Instance = &simulation.instances()[0];
            let before = instance.history.previous().frames[1].rotation;
            let after = instance.state.frames[1].rotation;
            let h = instance.history.last_step();
            // Between two steps: the angle's own, not its chord's.
            let turn = supple::internal::math::rotation_log(after * before.transpose()) / h;
            let middle = rotation_exp(-0.5 * h * turn) * after;
            let spin = DMat3::from_cols(
                turn.cross(middle.x_axis),
                turn.cross(middle.y_axis),
                turn.cross(middle.z_axis),
            );
            (
                momentum(middle, spin),
                0.5 * momentum(middle, spin).dot(turn),
            )
        };
        let energy = 0.5 * start.dot(spin);
        let mut highest: f64 = 0.0;
        for _ in 0..60 {
            simulation.step_blocking()?;
            highest = highest.max(now(&simulation).1 / energy);
        }
        let (end, _) = now(&simulation);
        let kept = end.length() / start.length();
        let angle = end.angle_between(start).to_degrees();
        println!(
            "history {history}: {kept:.4} of the spin, {angle:.2}°, energy up to {highest:.4}"
        );
        assert!(kept > 0.97 && kept < 1.01, "{kept}");
        assert!(angle < 1.0, "{angle}°");
        assert!(highest < 1.01, "{highest}");
    }
    Ok(())
}
