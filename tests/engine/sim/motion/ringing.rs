//! Tissue that is let go, and tissue whose bone brakes.

use super::{Mode, fit, simulation};
use crate::support;
use std::f64::consts::PI;
use supple::Result;
use supple::glam::DVec3;
use supple::internal::math::Random;
use supple::material::{Material, StableNeoHookean};
use supple::model::{Avatar, Frame};
use supple::sim::{Pin, Settings};

/// The limb, one bone in its middle, its tissue so soft that its first mode swings with `frequency` (Hz).
pub fn soft_limb(frequency: f64) -> Result<(Avatar, Mode)> {
    let mut avatar = support::full_space_limb(&support::SMALL, 1, true);
    let unscaled = Mode::first(&avatar)?;
    let Material::StableNeoHookean(law) = avatar.material else {
        unreachable!("the limb's law");
    };
    avatar.material = Material::StableNeoHookean(StableNeoHookean {
        youngs_modulus: law.youngs_modulus * (frequency / unscaled.frequency).powi(2),
        ..law
    });
    let mode = Mode::first(&avatar)?;
    Ok((avatar, mode))
}

/// Lengths of frames, s.
fn frames(kind: &str) -> impl FnMut() -> f64 {
    let kind = kind.to_owned();
    let (mut random, mut count) = (Random::new(5), 0);
    move || {
        count += 1;
        match &kind[..] {
            "random" => random.uniform(0.004, 0.033),
            "hitches" if count % 12 == 0 => 0.1,
            "hitches" => 1.0 / 60.0,
            rate => 1.0 / rate.parse::<f64>().unwrap(),
        }
    }
}

/// The first mode decays by its recipe's damping ratio at any rate of frames: its rate a second within 0.015 of ζ times
/// 2πf₁, and its frequency within 10 %.
#[test]
fn a_swing_decays_by_its_damping_ratio_at_any_rate() -> Result<()> {
    let (mut avatar, mode) = soft_limb(4.0)?;
    assert!((mode.frequency - 4.0).abs() < 1e-3, "{} Hz", mode.frequency);
    let omega = 2.0 * PI * mode.frequency;
    for ratio in [0.1, 0.2] {
        avatar.set_damping_time(ratio / (PI * mode.frequency));
        for kind in ["250", "120", "90", "60", "30", "random", "hitches"] {
            let mut simulation = simulation(&avatar, Settings::default());
            let instance = &mut simulation.instances_mut()[0];
            instance.gravity = DVec3::ZERO;
            let frame = instance.state.frames[0];
            instance.pins.push(Pin { bone: 0, frame });
            let mut state = instance.state.clone();
            for (handle, shape) in state.handles.iter_mut().zip(&mode.shape) {
                *handle = 2e-3 * *shape;
            }
            instance.set_state(state);
            let (mut time, mut next) = (0.0, frames(kind));
            let mut samples = vec![(0.0, 2e-3)];
            while time < 1.2 {
                let time_step = next();
                simulation.set_settings(Settings {
                    time_step,
                    ..Settings::default()
                })?;
                let report = simulation.step_blocking()?;
                assert_eq!(report.instances[0].iterations, 1, "{kind}");
                time += time_step;
                samples.push((time, mode.amplitude(&simulation.instances()[0].state)));
            }
            let (sigma, swing) = fit(&samples, omega);
            let (damping, pitch) = (sigma / omega, swing / omega);
            println!("{kind}: ζ {damping:.3} for {ratio}, f × {pitch:.3}");
            assert!(
                (damping - ratio).abs() < 0.015,
                "{kind}: ζ {damping} for {ratio}"
            );
            assert!((pitch - 1.0).abs() < 0.1, "{kind}: f × {pitch}");
        }
    }
    Ok(())
}

/// Half swings above a tenth of the first, and the first, m, of tissue at `frequency` (Hz) with a damping ratio when its
/// bone brakes from 2 m/s in 0.1 s.
fn braked(avatar: &Avatar, mode: &Mode, rate: f64) -> Result<(usize, f64)> {
    let h = 1.0 / rate;
    let place = |time: f64| {
        // v = 2 m/s until 0, then evenly to 0 at 0.1 s.
        let braking = time.clamp(0.0, 0.1);
        2.0 * (time.min(0.0) + braking - 5.0 * braking * braking)
    };
    // Along the way that the mode sways.
    let sway: DVec3 = mode.momentum.iter().sum();
    let direction = sway.normalize();
    let settings = Settings {
        time_step: h,
        ..Settings::default()
    };
    let mut simulation = simulation(avatar, settings);
    let instance = &mut simulation.instances_mut()[0];
    instance.gravity = DVec3::ZERO;
    let at = |time: f64| Frame {
        position: direction * place(time),
        ..Frame::IDENTITY
    };
    instance.pins.push(Pin {
        bone: 0,
        frame: at(0.0),
    });
    let mut state = instance.state.clone();
    state.frames[0] = at(0.0);
    instance.set_state(state.clone());
    let past = [1.0, 2.0, 3.0].map(|k| {
        let mut past = state.clone();
        past.frames[0] = at(-k * h);
        past
    });
    instance.history.set_motion(past, h);
    let mut swings: Vec<f64> = vec![0.0];
    for step in 1..=(2.0 * rate) as usize {
        simulation.instances_mut()[0].pins[0].frame = at(step as f64 * h);
        simulation.step_blocking()?;
        let state = &simulation.instances()[0].state;
        let handles = state.handles.len() as f64;
        let y = state.handles.iter().sum::<DVec3>().dot(direction) / handles;
        // Each half swing's largest.
        match swings.last_mut() {
            Some(last) if *last * y >= 0.0 => *last = if y.abs() > last.abs() { y } else { *last },
            _ => swings.push(y),
        }
    }
    let first = swings.iter().fold(0.0, |a: f64, s| a.max(s.abs()));
    let count = swings.iter().filter(|s| s.abs() > 0.1 * first).count();
    Ok((count, first))
}

/// A belly at 4.5 Hz whose bone brakes: as many half swings as its bounce says, one more or less, and the first as wide as
/// with steps of 1 ms, within 10 %.
#[test]
fn a_brake_swings_as_wide_at_any_rate() -> Result<()> {
    let (mut avatar, mode) = soft_limb(4.5)?;
    for (bounce, swings) in [(0.0, 1..=2), (0.5, 3..=5), (1.0, 9..=usize::MAX)] {
        let ratio = 10f64.powf(-1.5 * bounce);
        avatar.set_damping_time(ratio / (PI * mode.frequency));
        let (_, truth) = braked(&avatar, &mode, 1000.0)?;
        for rate in [144.0, 90.0, 60.0, 45.0, 30.0] {
            let (count, first) = braked(&avatar, &mode, rate)?;
            println!(
                "bounce {bounce}, {rate} Hz: {count} half swings, {:.1} mm of {:.1} mm",
                1e3 * first,
                1e3 * truth
            );
            let (least, most) = (
                swings.start().saturating_sub(1),
                swings.end().saturating_add(1),
            );
            assert!((least..=most).contains(&count), "{bounce}, {rate}: {count}");
            assert!(
                (first / truth - 1.0).abs() < 0.1,
                "{bounce}, {rate}: {first} of {truth}"
            );
        }
    }
    Ok(())
}
