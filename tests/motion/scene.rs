//! Scenes whose bones follow a motion.
