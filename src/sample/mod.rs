//! Models made by the crate itself: a limb, a finger, a hand, a body; and seeded random ones.

mod body;
mod dual_quaternion;
mod field;
mod finger;
pub mod hand;
mod heat_weights;
pub mod limb;
mod polygonise;
mod pose_columns;
mod random;
mod regressor;
mod remesh;
mod shape_motion;
mod topology;
mod walk;

pub use body::{SampleBody, body};
pub use finger::Finger;
pub use hand::{SampleHand, grasp, hand};
pub use limb::Limb;
pub use random::{random_avatar, random_state};
pub use walk::walk;
