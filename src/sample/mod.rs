//! Models made by the crate itself: a limb, a finger, a hand.
