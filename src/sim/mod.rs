//! The step: state, Newton's method, the reduced linear system.
//!
//! The files in the order in which the data flows. Each imports from those above it only:
//!
//! | file | what it does |
//! |---|---|
//! | `settings` | what stays the same through a simulation |
//! | `waking_memory` | what waking remembers of an instance |
//! | `skin_spring` | springs from points of the skin to places of the host's |
//! | `instance` | an avatar's state and what drives it, written by the user between steps |
//! | `waking` | which fine handles are awake in the next step |
//! | `prediction` | where the minimisation starts: the inertial prediction, and qⁿ as its fall-back |
//! | `carried` | bones without mass, which the others carry along |
//! | `spring_bones` | the dynamics of those of them that swing |
//! | `substeps` | how a frame is cut into steps, and where what drives it is in between |
//! | `step_start` | what the skeleton's and the tissue's energies are told at the start of a step |
//! | `report` | what a step tells about itself |
//! | `linear_solver` | H δ = −g: the interface, scaling, products |
//! | `dense_cholesky` | its solver for the reduced system |
//! | `solvers` | one for each thread |
//! | `members` | the instances of one asset or of several, evaluated together |
//! | `groups` | which of them one linear system moves |
//! | `minimisation` | one instance's Newton step from its evaluation |
//! | `iterates` | all instances' iterates, evaluated together |
//! | `coupled` | the linear systems of groups |
//! | `line_search` | how far they move along their steps |
//! | `iteration` | what an observer sees of an iteration |
//! | `newton` | the iterations |
//! | `step_end` | what the states that a step ends with tell |
//! | `stepper` | a step of members of any assets, from its start to the new states |
//! | `simulation` | avatars of one asset, stepped together |
//! | `settle` | where everything comes to rest |
//! | `energy_balance` | mechanical energy, measured between steps |
//! | `step_potential` | E of a step with its derivatives, for who looks at it from outside |

mod carried;
mod coupled;
mod dense_cholesky;
mod energy_balance;
mod groups;
mod instance;
mod iterates;
mod iteration;
mod line_search;
pub(crate) mod linear_solver;
mod members;
mod minimisation;
mod newton;
mod prediction;
mod report;
mod settings;
pub(crate) mod settle;
mod simulation;
mod skin_spring;
mod solvers;
mod spring_bones;
mod step_end;
mod step_potential;
mod step_start;
mod stepper;
mod substeps;
mod waking;
mod waking_memory;

pub(crate) use groups::Link;
pub(crate) use members::Members;
pub(crate) use solvers::Solvers;
pub(crate) use stepper::{Physics, Stepper};
pub(crate) use substeps::{DrivenFrame, Split};
pub(crate) use waking::Waking;
pub(crate) use waking_memory::WakingMemory;

pub use dense_cholesky::DenseCholesky;
pub use energy_balance::EnergyBalance;
pub use instance::{Instance, Pin, SpringMode};
pub use iteration::{Iteration, Observer};
pub use linear_solver::{LinearSolver, SolveReport};
pub use report::{InstanceReport, Load, StepReport, Stop, Timings};
pub use settings::{LARGEST_JOINT_STIFFNESS, Settings, SolverMode};
pub use simulation::Simulation;
pub use skin_spring::SkinSpring;
pub use step_potential::{StepEnergies, StepPotential};
