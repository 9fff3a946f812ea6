//! Joints swing by their springs and dampers.

use super::{fit, simulation};
use crate::support;
use std::f64::consts::TAU;
use supple::Result;
use supple::glam::DVec3;
use supple::internal::math::{rotation_exp, rotation_log};
use supple::model::{Avatar, Frame};
use supple::sim::{Pin, Settings};
use supple_bake::without_tissue;

/// Angle of a forearm on a held upper arm that was bent by 0.05 rad, after each step of a second.
fn swing(avatar: &Avatar, settings: Settings, damping: f64) -> Result<Vec<(f64, f64)>> {
    let mut simulation = simulation(avatar, settings);
    let instance = &mut simulation.instances_mut()[0];
    instance.gravity = DVec3::ZERO;
    let mut state = instance.state.clone();
    let frame = state.frames[0];
    instance.pins.push(Pin { bone: 0, frame });
    state.frames[1] = Frame {
        rotation: rotation_exp(DVec3::Y * 0.05),
        ..state.frames[1]
    };
    instance.set_state(state);
    instance.bending[1].damping = damping;
    let steps = (1.0 / settings.time_step).round() as usize;
    (1..=steps)
        .map(|step| {
            simulation.step_blocking()?;
            let turn = rotation_log(simulation.instances()[0].state.frames[1].rotation);
            Ok((step as f64 * settings.time_step, turn.y))
        })
        .collect()
}

/// ζ = d ω/(2k) of a joint with a spring k and a damper d, at any rate of frames; bound as that of tissue (motion.md §6).
#[test]
fn a_joint_swings_by_its_damping_ratio() -> Result<()> {
    let avatar = without_tissue(&support::full_space_limb(&support::SMALL, 2, true));
    let stiffness = 3.0;
    let settings = |rate: f64| Settings {
        time_step: 1.0 / rate,
        bending_stiffness: stiffness,
        ..Settings::default()
    };
    let (_, free) = fit(&swing(&avatar, settings(1000.0), 0.0)?, TAU * 5.0);
    println!("free: {} Hz", free / TAU);
    assert!((2.0..8.0).contains(&(free / TAU)), "{} Hz", free / TAU);
    for wanted in [0.1, 0.2] {
        let damping = 2.0 * stiffness * wanted / free;
        for rate in [240.0, 60.0] {
            let (decay, _) = fit(&swing(&avatar, settings(rate), damping)?, free);
            let ratio = decay / free;
            println!("ζ {wanted} at {rate} Hz: {ratio:.4}");
            assert!(
                (ratio - wanted).abs() < 0.015,
                "ζ {wanted} at {rate} Hz: {ratio}"
            );
        }
    }
    Ok(())
}
