//! What is pressed and held pushes back evenly.

use super::simulation;
use crate::support;
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::material::{Material, StableNeoHookean};
use supple::model::{Avatar, Frame};
use supple::sim::{Pin, Settings, SolverMode};

/// Depth of the press, and radius of the ball, m.
const DEPTH: f64 = 0.008;
const RADIUS: f64 = 0.03;

/// A limb of 2 kPa whose contact is as stiff as its tissue asks for.
fn soft() -> Avatar {
    const YOUNGS_MODULUS: f64 = 2e3;
    let mut avatar = support::full_space_limb(&support::SMALL, 1, true);
    avatar.material = Material::StableNeoHookean(StableNeoHookean {
        youngs_modulus: YOUNGS_MODULUS,
        poissons_ratio: 0.4,
    });
    let depth = support::SMALL.outer_radius - support::SMALL.inner_radius;
    avatar.contact_stiffness = vec![100.0 * YOUNGS_MODULUS / depth; avatar.skin.len()];
    avatar.set_damping_time(0.01);
    avatar
}

/// The force of each step of a press at 1 m/s that is then held, N.
fn press(avatar: &Avatar, rate: f64) -> Result<Vec<f64>> {
    let settings = Settings {
        time_step: 1.0 / rate,
        solver: SolverMode::Budgeted { max_iterations: 1 },
        ..Settings::default()
    };
    let mut simulation = simulation(avatar, settings);
    let at = |depth: f64| Frame {
        position: DVec3::new(0.1, 0.0, support::SMALL.outer_radius + RADIUS - depth),
        ..Frame::IDENTITY
    };
    let instance = &mut simulation.instances_mut()[0];
    let frame = instance.state.frames[0];
    instance.pins.push(Pin { bone: 0, frame });
    let ball = Shape::Sphere { radius: RADIUS };
    instance.colliders.push(Collider::new(ball, at(-0.002)));
    let steps = 2 * rate as usize;
    (1..=steps)
        .map(|step| {
            let depth = (step as f64 / rate - 0.002).min(DEPTH);
            simulation.instances_mut()[0].colliders[0].frame = at(depth);
            let report = simulation.step_blocking()?.instances.remove(0);
            Ok(report.contact_force.length())
        })
        .collect()
}

/// Bounds of motion.md §6.
#[test]
fn a_held_press_does_not_chatter_and_a_fast_one_peaks_little() -> Result<()> {
    let avatar = soft();
    for rate in [60.0, 100.0] {
        let forces = press(&avatar, rate)?;
        let held = &forces[forces.len() / 2..];
        let mean = held.iter().sum::<f64>() / held.len() as f64;
        let least = held.iter().copied().fold(f64::INFINITY, f64::min);
        let most = held.iter().copied().fold(0.0, f64::max);
        let peak = forces.iter().copied().fold(0.0, f64::max);
        println!(
            "{rate} Hz: {mean:.4} N, scatter {:.4}, peak × {:.2}",
            (most - least) / mean,
            peak / mean
        );
        assert!(mean > 0.01, "{mean} N");
        assert!(
            most - least <= 0.02 * mean,
            "{rate} Hz: {least} to {most} N"
        );
        assert!(peak <= 2.5 * mean, "{rate} Hz: {peak} of {mean} N");
    }
    Ok(())
}
