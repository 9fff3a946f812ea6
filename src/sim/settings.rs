//! What stays the same through a simulation.

use crate::model::Integrator;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// Largest joint spring whose reduced system still solves well in f32 (scaled condition 3e4), N/m.
pub const LARGEST_JOINT_STIFFNESS: f64 = 1e6;

/// How far a step minimises the incremental potential.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "mode", rename_all = "snake_case", deny_unknown_fields)]
#[non_exhaustive]
pub enum SolverMode {
    /// The paper's mode, which wants [`Integrator::BackwardEuler`]: one Newton iteration, so one linear solve, from
    /// the inertial prediction with closed joints (from the tissue at qⁿ, or from qⁿ, where that has less energy). Its step
    /// is taken whole and on trust up to 1 mm; a longer one means that something unforeseen happened, and is halved until it lowers
    /// the energy, which costs an evaluation of E for each few lengths. One iteration does not see the
    /// contacts that it makes, nor how far friction gives way: on the bone press it is 0.02 mm off the
    /// converged run while pressing and up to 1.9 mm while the sphere slides and leaves (4.8 mm if every
    /// step were taken whole), where [`SolverMode::TWO_ITERATIONS`] is 0.3 mm off.
    OneIteration,
    /// As many iterations as the step itself asks for, at most `max_iterations` of them: the default. A step shorter than
    /// 1 mm with no collider near takes one, on trust. Any other is searched along, which costs an evaluation of E, and is
    /// the last where E falls as the quadratic model said that it would and contacts do what it foresaw: where they open or
    /// close, friction gives way or tissue stiffens, another iteration follows.
    Budgeted {
        /// Iterations before the step is taken as it is.
        #[serde(default = "default_budget")]
        max_iterations: usize,
    },
    /// Newton with a line search until a step is shorter than `tolerance`.
    Converged {
        /// Length of the longest step of a joint or a handle that counts as none, m. A rotation
        /// counts with the lever of 0.1 m.
        #[serde(default = "default_tolerance")]
        tolerance: f64,
        /// Iterations before the step is taken as it is, and said to be so in its report.
        #[serde(default = "default_max_iterations")]
        max_iterations: usize,
    },
}

impl SolverMode {
    /// [`SolverMode::Converged`] with the default tolerance (1e-8 m) and at most 100 iterations.
    pub const CONVERGED: Self = Self::Converged {
        tolerance: 1e-8,
        max_iterations: 100,
    };

    /// [`SolverMode::Budgeted`] with the default budget of four.
    pub const BUDGETED: Self = Self::Budgeted { max_iterations: 4 };

    /// At most two iterations with a line search.
    pub const TWO_ITERATIONS: Self = Self::Converged {
        tolerance: 1e-6,
        max_iterations: 2,
    };
}

fn default_budget() -> usize {
    4
}

fn default_tolerance() -> f64 {
    1e-8
}

fn default_max_iterations() -> usize {
    100
}

/// Constants of a [`Simulation`](super::Simulation).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// h, s.
    pub time_step: f64,
    /// Which formula a step differentiates by.
    pub integrator: Integrator,
    /// The longest step under [`Integrator::Bdf2`], s: a longer frame takes several. 17.5 ms for games; 8.75 ms for swings
    /// within 1 % of their frequency.
    pub longest_step: f64,
    /// What of the root's acceleration is beyond this is not felt, m/s²: a host that puts a character elsewhere without a word
    /// does not tear its tissue off. Only where the root is prescribed.
    pub largest_acceleration: f64,
    /// How far a step minimises.
    pub solver: SolverMode,
    /// k of the springs that hold joints together, N/m; at most [`LARGEST_JOINT_STIFFNESS`].
    pub joint_stiffness: f64,
    /// Initial k of the springs that keep each bone's rotation relative to its parent, N·m/rad.
    pub bending_stiffness: f64,
    /// Initial k of the springs that keep joints within their ranges, N·m/rad.
    pub limit_stiffness: f64,
    /// Initial d/k of the dampers beside both, s: what springs back overdamped takes about so long.
    pub joint_damping_time: f64,
    /// ε_v, m/s: slower slip than this meets less than the whole friction, so that what rests creeps by it at most.
    pub slip_speed: f64,
    /// Whether the Hessian holds the geometric terms of contact (Σ fᵀ ∂²x/∂q²) as well; where it is not positive
    /// definite with them, they are dropped. Off by default: they help little. On the free finger of `finger_press`
    /// a converged step takes 2.38 iterations in contact instead of 2.48, and one iteration is 0.012 mm off the
    /// converged run at most instead of 0.017 mm; where bones are prescribed, as in `bone_press_s` (7.38 iterations
    /// either way), they change nothing. On the GPU they cost a readback of the contacts and an assembly on the CPU.
    pub geometric_contact: bool,
    /// Whether reports are of the state that a step ends with also where no bone is pinned; where one is, they are. It costs
    /// an evaluation without second derivatives (on the CPU 0.25 to 0.4 ms of the sample hand's step), and a [`Simulation`]
    /// on the GPU a submission and a readback, so that it is off by default; a [`World`](crate::World), where it costs
    /// neither of these, has it on.
    ///
    /// [`Simulation`]: super::Simulation
    pub report_at_end: bool,
    /// How many fine handles of an instance may be awake at a time, on the CPU and of an avatar that was baked with some. A
    /// [`World`](crate::World) makes room for so many; elsewhere
    /// [`Avatar::with_fine_slots`](crate::model::Avatar::with_fine_slots) does. 0 is the paper's model.
    pub fine_handles: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            time_step: 0.01,
            integrator: Integrator::default(),
            longest_step: 0.0175,
            largest_acceleration: 80.0,
            solver: SolverMode::BUDGETED,
            joint_stiffness: 1e6,
            bending_stiffness: 10.0,
            limit_stiffness: 1e3,
            joint_damping_time: 0.05,
            slip_speed: 1e-3,
            geometric_contact: false,
            report_at_end: false,
            fine_handles: 30,
        }
    }
}

impl Settings {
    /// Checks every value.
    pub fn validate(&self) -> Result<()> {
        positive("settings.time_step", self.time_step, "seconds")?;
        positive("settings.longest_step", self.longest_step, "seconds")?;
        positive(
            "settings.largest_acceleration",
            self.largest_acceleration,
            "m/s²",
        )?;
        if !(0.0..=LARGEST_JOINT_STIFFNESS).contains(&self.joint_stiffness) {
            return Err(Error::invalid(
                "settings.joint_stiffness",
                format!(
                    "{} is not within 0 and {LARGEST_JOINT_STIFFNESS:e} N/m",
                    self.joint_stiffness
                ),
            ));
        }
        not_negative(
            "settings.bending_stiffness",
            self.bending_stiffness,
            "N·m/rad",
        )?;
        not_negative("settings.limit_stiffness", self.limit_stiffness, "N·m/rad")?;
        not_negative(
            "settings.joint_damping_time",
            self.joint_damping_time,
            "seconds",
        )?;
        positive("settings.slip_speed", self.slip_speed, "m/s")?;
        let max_iterations = match self.solver {
            SolverMode::OneIteration => 1,
            SolverMode::Budgeted { max_iterations } => max_iterations,
            SolverMode::Converged {
                tolerance,
                max_iterations,
            } => {
                positive("settings.solver.tolerance", tolerance, "metres")?;
                max_iterations
            }
        };
        if max_iterations == 0 {
            return Err(Error::invalid(
                "settings.solver.max_iterations",
                "0 iterations never move anything; give at least 1",
            ));
        }
        Ok(())
    }
}

/// An error unless `value` is finite and above 0.
fn positive(field: &str, value: f64, unit: &str) -> Result<()> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::invalid(
        field,
        format!("{value} is not a positive number of {unit}"),
    ))
}

/// An error unless `value` is finite and at least 0.
pub(super) fn not_negative(field: &str, value: f64, unit: &str) -> Result<()> {
    if value >= 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(Error::invalid(
        field,
        format!("{value} is neither 0 nor a positive number of {unit}"),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_read_from_toml_and_unknown_keys_are_refused() {
        let read: Settings =
            toml::from_str("time_step = 0.005\n[solver]\nmode = \"converged\"\ntolerance = 1e-6")
                .unwrap();
        let solver = SolverMode::Converged {
            tolerance: 1e-6,
            max_iterations: 100,
        };
        let expected = Settings {
            time_step: 0.005,
            solver,
            ..Settings::default()
        };
        assert_eq!(read, expected);
        for bad in [
            "timestep = 0.005",
            "[solver]\nmode = \"converged\"\ntolerence = 1e-6",
            "[solver]\nmode = \"newton\"",
        ] {
            assert!(toml::from_str::<Settings>(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn unusable_values_are_refused_by_name() {
        let base = Settings::default();
        let converged = |tolerance, max_iterations| Settings {
            solver: SolverMode::Converged {
                tolerance,
                max_iterations,
            },
            ..base
        };
        let cases = [
            (
                Settings {
                    time_step: 0.0,
                    ..base
                },
                "time_step",
            ),
            (
                Settings {
                    time_step: f64::NAN,
                    ..base
                },
                "time_step",
            ),
            (
                Settings {
                    joint_stiffness: 1e7,
                    ..base
                },
                "joint_stiffness",
            ),
            (
                Settings {
                    joint_stiffness: f64::NAN,
                    ..base
                },
                "joint_stiffness",
            ),
            (
                Settings {
                    bending_stiffness: -1.0,
                    ..base
                },
                "bending_stiffness",
            ),
            (
                Settings {
                    limit_stiffness: f64::NAN,
                    ..base
                },
                "limit_stiffness",
            ),
            (converged(0.0, 10), "tolerance"),
            (converged(1e-8, 0), "max_iterations"),
        ];
        for (settings, field) in cases {
            let message = settings.validate().unwrap_err().to_string();
            assert!(message.contains(field), "{message}");
        }
        assert!(base.validate().is_ok() && converged(1e-8, 1).validate().is_ok());
    }
}
