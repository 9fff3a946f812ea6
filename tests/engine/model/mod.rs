//! What an avatar is.

mod joints;
mod refused_joints;
mod standing;
