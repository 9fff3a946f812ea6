//! One pose of a WebXR hand, as JSON or as the literal of a script.

mod js_literal;
mod read;

pub use read::{parse_pose, read_pose};
