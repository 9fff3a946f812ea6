//! Models made by the crate itself: a limb, a finger, a hand, a body; and seeded random ones.

mod body;
mod dual_quaternion;
mod field;
mod finger;
pub mod hand;
mod heat_weights;
mod kept;
mod polygonise;
mod pose_columns;
mod regressor;
mod remesh;
mod sample;
mod shape_motion;
mod topology;
mod walk;

pub use body::{SampleBody, body};
pub use finger::Finger;
pub use hand::{SampleHand, grasp, hand};
pub use sample::{PALM, SOFT, Sample, SampleShape, limb_recipe, map_of};
pub use supple_bake::Limb;
pub use walk::walk;

#[cfg(test)]
mod tests;
