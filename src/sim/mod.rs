//! The step: state, Newton's method, the reduced linear system.

mod dense_cholesky;
mod energy;
mod instance;
mod iterates;
mod line_search;
pub(crate) mod linear_solver;
mod minimisation;
mod newton;
mod prediction;
mod report;
mod settings;
mod simulation;

pub use dense_cholesky::DenseCholesky;
pub use energy::EnergyBalance;
pub use instance::{Instance, Pin};
pub use linear_solver::{LinearSolver, SolveReport};
pub use report::{InstanceReport, Load, StepReport, Stop, Timings};
pub use settings::{LARGEST_JOINT_STIFFNESS, Settings, SolverMode};
pub use simulation::Simulation;
