//! What holds for the whole world.

use crate::model::{Integrator, UpAxis};
use crate::sim::{Settings, SolverMode};
use glam::DVec3;
use serde::{Deserialize, Serialize};

#[derive(Serialize, Deserialize)]
pub(super) struct StoredWorld {
    pub settings: StoredSettings,
    pub up: UpAxis,
    pub gravity: DVec3,
}

/// [`Settings`] without tags in text, which the sections' format has none of.
#[derive(Serialize, Deserialize)]
pub(super) struct StoredSettings {
    pub time_step: f64,
    /// Tolerance and most iterations; none of the one-iteration mode.
    pub converged: Option<(f64, usize)>,
    pub joint_stiffness: f64,
    pub bending_stiffness: f64,
    pub limit_stiffness: f64,
    pub slip_speed: f64,
    pub geometric_contact: bool,
    pub report_at_end: bool,
}

impl From<Settings> for StoredSettings {
    fn from(settings: Settings) -> Self {
        Self {
            time_step: settings.time_step,
            converged: match settings.solver {
                SolverMode::OneIteration | SolverMode::Budgeted { .. } => None,
                SolverMode::Converged {
                    tolerance,
                    max_iterations,
                } => Some((tolerance, max_iterations)),
            },
            joint_stiffness: settings.joint_stiffness,
            bending_stiffness: settings.bending_stiffness,
            limit_stiffness: settings.limit_stiffness,
            slip_speed: settings.slip_speed,
            geometric_contact: settings.geometric_contact,
            report_at_end: settings.report_at_end,
        }
    }
}

impl From<StoredSettings> for Settings {
    fn from(stored: StoredSettings) -> Self {
        let converged = |(tolerance, max_iterations)| SolverMode::Converged {
            tolerance,
            max_iterations,
        };
        Self {
            time_step: stored.time_step,
            integrator: Integrator::BackwardEuler,
            longest_step: Settings::default().longest_step,
            largest_acceleration: f64::MAX,
            solver: stored.converged.map_or(SolverMode::OneIteration, converged),
            joint_stiffness: stored.joint_stiffness,
            bending_stiffness: stored.bending_stiffness,
            limit_stiffness: stored.limit_stiffness,
            joint_damping_time: 0.0,
            slip_speed: stored.slip_speed,
            geometric_contact: stored.geometric_contact,
            report_at_end: stored.report_at_end,
            fine_handles: 0,
        }
    }
}

/// What [`StoredSettings`] do not say.
#[derive(Serialize, Deserialize)]
pub(super) struct StoredIntegration {
    pub bdf2: bool,
    pub longest_step: f64,
    pub largest_acceleration: f64,
    pub joint_damping_time: f64,
    /// Of the budgeted solver.
    pub budget: Option<usize>,
}
