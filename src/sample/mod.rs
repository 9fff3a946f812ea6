//! Models made by the crate itself: a limb, a finger, a hand; and seeded random ones.

mod finger;
pub mod hand;
pub mod limb;
mod random;

pub use finger::Finger;
pub use hand::{SampleHand, hand};
pub use limb::Limb;
pub use random::{random_avatar, random_state};
