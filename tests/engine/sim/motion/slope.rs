//! A soft block on a slope.

use super::CONVERGED;
use crate::support;
use std::sync::Arc;
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::glam::DVec3;
use supple::model::{Frame, Integrator};
use supple::potential::{CpuPotential, Potential};
use supple::sim::{Settings, Simulation};
use supple_bake::SparseCholesky;

const FRICTION: f64 = 0.5;

/// Speed along the slope after two seconds, m/s, from `speed`; the expected one; mean iterations.
fn slides(degrees: f64, speed: f64, rate: f64) -> Result<(f64, f64, f64)> {
    let mut avatar = support::full_space_limb(&support::SMALL, 1, false);
    avatar.set_damping_time(0.01);
    let potential = CpuPotential::new(Arc::new(avatar.clone()), 1)?;
    let settings = Settings {
        time_step: 1.0 / rate,
        ..Settings::default()
    };
    let sparse = Box::new(SparseCholesky::new(potential.pattern())?);
    let mut simulation = Simulation::with_solver(&avatar, potential, settings, sparse)?;
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let instance = &mut simulation.instances_mut()[0];
    instance.gravity = 9.81 * DVec3::new(0.0, 0.0, -1.0);
    let lowest = avatar
        .skin
        .position
        .iter()
        .fold(0.0, |a: f64, p| a.min(p.z));
    let ground = Frame {
        position: DVec3::Z * lowest,
        ..Frame::IDENTITY
    };
    instance.colliders.push(Collider {
        friction: FRICTION,
        ..Collider::new(Shape::HalfSpace, ground)
    });
    // It lies down first, then the slope tilts.
    simulation.set_settings(Settings {
        solver: CONVERGED,
        integrator: Integrator::BackwardEuler,
        ..settings
    })?;
    for _ in 0..100 {
        simulation.step_blocking()?;
    }
    simulation.set_settings(settings)?;
    let instance = &mut simulation.instances_mut()[0];
    let state = instance.state.clone();
    instance.set_state(state);
    if speed > 0.0 {
        let at = instance.state.frames[0];
        instance.set_motion(0, at, DVec3::X * speed, DVec3::ZERO);
    }
    instance.gravity = 9.81 * DVec3::new(sine, 0.0, -cosine);
    let steps = (2.0 * rate) as usize;
    let mut iterations = 0;
    for _ in 0..steps {
        let report = simulation.step_blocking()?.instances.remove(0);
        iterations += report.iterations;
    }
    let instance = &simulation.instances()[0];
    let (before, after) = (instance.history.previous(), &instance.state);
    let moved = after.frames[0].position.x - before.frames[0].position.x;
    let pull = 9.81 * (sine - FRICTION * cosine);
    let expected = match sine > FRICTION * cosine {
        true => speed + 2.0 * pull,
        // Below the angle of friction it stops.
        false => f64::max(0.0, speed + 2.0 * pull),
    };
    Ok((moved * rate, expected, iterations as f64 / steps as f64))
}

#[test]
fn a_soft_block_slides_as_coulomb_says() -> Result<()> {
    let mut failures = Vec::new();
    for rate in [60.0, 100.0] {
        for (degrees, speed) in [
            (20.0, 0.0),
            (20.0, 0.3),
            (35.0, 0.0),
            (45.0, 0.3),
            (60.0, 0.0),
        ] {
            let (end, expected, iterations) = slides(degrees, speed, rate)?;
            println!(
                "{degrees}° from {speed} m/s at {rate} Hz: {end:.3} m/s of {expected:.3}, {iterations:.2} iterations"
            );
            // At rest it creeps by less than the slip speed.
            if (end - expected).abs() > 0.03 * expected + 1e-3 {
                failures.push(format!(
                    "{degrees}°, {speed} m/s, {rate} Hz: {end} of {expected}"
                ));
            }
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    Ok(())
}
