//! The bones' own energies: joints, bending stiffness, tracking of targets, inertia and gravity.
//!
//! They depend on the frames alone, are assembled on the CPU in f64, and go into the frame–frame
//! blocks of the reduced system. Every term stands in one file with its formula, its energy
//! difference (summed from increments, so that it keeps its digits near rest), its gradient and its
//! positive semi-definite Gauss–Newton Hessian. Rotations step by R ← exp(\[δω\]) R everywhere.

mod bending;
mod bone_inertia;
mod gravity;
mod joint;
mod limit;
mod log_derivative;
mod swing_twist;
mod system;
mod term;
mod tracking;

pub use bending::{Bending, BendingSpring};
pub use bone_inertia::BoneInertia;
pub use gravity::{FrameGravity, TissueMoments};
pub use joint::{JointSpring, joint_gap};
pub use limit::{JointLimit, LimitSpring};
pub use log_derivative::{inverse_left_jacobian, log_curvature};
pub use system::{SkeletonEnergies, SkeletonModel, SkeletonPotential, SkeletonStart};
pub use term::{FrameHessian, FrameTerm, Residual, rotation_curvature};
pub use tracking::{Spring, Tracking, TrackingSpring};
