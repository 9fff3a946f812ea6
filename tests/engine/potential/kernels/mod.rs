//! Every kernel against its f64 twin, from the very numbers that the kernel read.

pub mod bound;
pub mod compact;
pub mod contact;
pub mod energies;
pub mod friction;
pub mod input;
pub mod material;
pub mod points;
pub mod scene;
pub mod select;
pub mod sums;

use bound::Outcome;
use scene::{Phase, Scene};

/// A check of one kernel: its name, the part of the scene it looks at, and the comparison.
pub type Check = (&'static str, fn(&Scene) -> Outcome);

/// One check a kernel, in the order of the data.
pub const CHECKS: &[Check] = &[
    ("pose_blend", points::pose_blend),
    ("displacement", points::displacement),
    ("inertial_target", points::inertial_target),
    ("elasticity", points::elasticity),
    ("contact", contact::contact),
    ("select", select::select),
    ("friction", friction::friction),
    ("compact", compact::compact),
    ("gradient", sums::gradient),
    ("point_hessian", sums::point_hessian),
    ("hessian", sums::hessian),
    ("energy", energies::energy),
    ("skin", points::skin),
    ("normals", points::normals),
];

/// The instance that is looked at: not the first, so that a kernel that forgets the instance is found.
pub const INSTANCE: usize = 1;
/// Instances of the batch.
pub const INSTANCES: usize = 2;
/// States of a batch besides the starts: trials and their bases.
pub const STATES: usize = 4;

impl Phase {
    /// Slot of the looked-at state.
    pub fn slot(self) -> usize {
        match self {
            // The trial is the first state after the starts.
            Self::Compared => INSTANCES,
            Self::Evaluated => INSTANCES + INSTANCE,
            // What is posed has slots of its own at the end.
            Self::Posed => INSTANCES + STATES + INSTANCE,
        }
    }
}
