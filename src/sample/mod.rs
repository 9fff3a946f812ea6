//! Models made by the crate itself: a limb, a finger, a hand.

pub mod limb;

pub use limb::Limb;
