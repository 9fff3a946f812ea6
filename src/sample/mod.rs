//! Models made by the crate itself: a limb, a finger, a hand; and seeded random ones.

pub mod limb;
mod random;

pub use limb::Limb;
pub use random::{random_avatar, random_state};
