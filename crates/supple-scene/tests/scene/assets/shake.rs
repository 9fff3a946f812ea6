//! A shake: the root goes ±5 cm at 3 Hz for 200 steps of 10 ms.

use std::f64::consts::TAU;
use std::sync::Arc;
use supple::glam::DVec3;
use supple::internal::cpu::displacement::unposed_displacement;
use supple::internal::cpu::min_det_f;
use supple::model::Avatar;
use supple::potential::CpuPotential;
use supple::sim::{Pin, Settings, Simulation};

/// What else moves.
#[derive(Clone, Copy, Debug)]
pub enum Shake {
    /// Every bone goes with the root.
    Skeleton,
    /// The others hang on it by joints and bending springs, under gravity.
    RootAlone,
}

/// What a shake did.
#[derive(Debug)]
pub struct Shaken {
    /// Largest unposed displacement of a skin vertex, mm.
    pub peak_mm: f64,
    /// Smallest det F over all tets.
    pub min_det_f: f64,
    /// Largest gap of a joint, mm.
    pub joint_gap_mm: f64,
}

pub fn shake(avatar: &Avatar, how: Shake) -> Shaken {
    const STEPS: usize = 200;
    let avatar = Arc::new(avatar.clone());
    let potential = CpuPotential::new(avatar.clone(), 1).unwrap();
    let settings = Settings::default();
    let mut simulation = Simulation::new(&avatar, potential, settings).unwrap();
    let rest = avatar.rest_state();
    let mut out = Shaken {
        peak_mm: 0.0,
        min_det_f: 1.0,
        joint_gap_mm: 0.0,
    };
    let moved = match how {
        Shake::Skeleton => rest.frames.len(),
        Shake::RootAlone => 1,
    };
    for step in 1..=STEPS {
        let time = step as f64 * settings.time_step;
        let offset = 0.05 * (TAU * 3.0 * time).sin() * DVec3::X;
        let pin = |bone: usize| {
            let mut frame = rest.frames[bone];
            frame.position += offset;
            Pin { bone, frame }
        };
        simulation.instances_mut()[0].pins = (0..moved).map(pin).collect();
        let report = simulation.step_blocking().unwrap();
        let gap = 1e3 * report.instances[0].max_joint_gap;
        out.joint_gap_mm = out.joint_gap_mm.max(gap);
        let state = &simulation.instances()[0].state;
        for row in avatar.skin.basis.iter() {
            let displacement = unposed_displacement(row, &state.handles);
            out.peak_mm = out.peak_mm.max(1e3 * displacement.length());
        }
        // A period has 33 steps; every third sees its peaks.
        if step % 3 == 0 {
            let det = min_det_f(&avatar, state);
            out.min_det_f = if det < out.min_det_f || det.is_nan() {
                det
            } else {
                out.min_det_f
            };
        }
    }
    out
}
