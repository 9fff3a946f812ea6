//! The bones' own energies: joints, bending stiffness, tracking of targets, inertia and gravity.
//!
//! They depend on the frames alone, are assembled on the CPU in f64, and go into the frame–frame
//! blocks of the reduced system. Every term stands in one file with its formula, its energy
//! difference (summed from increments, so that it keeps its digits near rest), its gradient and its
//! positive semi-definite Gauss–Newton Hessian. Rotations step by R ← exp(\[δω\]) R everywhere.
//!
//! Each file imports from those above it only:
//!
//! | file | what it does |
//! |---|---|
//! | `log_derivative` | derivatives of a rotation's logarithm |
//! | `term` | the interface of a term, and what terms share |
//! | `joint` | springs that hold joints together |
//! | `bending` | springs and dampers between the rotations of a bone and its parent |
//! | `swing_twist` | a joint's rotation as swing and twist |
//! | `limit` | springs that keep joints within their ranges |
//! | `tracking` | springs and dampers to moving targets |
//! | `bone_inertia` | the inertia of rigid bones |
//! | `gravity` | gravity on bones and tissue |
//! | `preload` | the weight that springs carry beforehand |
//! | `system` | all terms of a skeleton together |

pub(crate) mod bending;
pub(crate) mod bone_inertia;
pub(crate) mod gravity;
pub(crate) mod joint;
pub(crate) mod limit;
pub(crate) mod log_derivative;
pub(crate) mod preload;
mod swing_twist;
pub(crate) mod system;
pub(crate) mod term;
pub(crate) mod tracking;

pub use bending::Bending;
pub(crate) use joint::joint_gap;
pub use limit::JointLimit;
pub use preload::Preload;
pub use system::{SkeletonEnergies, SkeletonPotential};
pub(crate) use system::{SkeletonModel, SkeletonStart};
pub(crate) use term::FrameHessian;
pub use tracking::{Spring, Tracking};
