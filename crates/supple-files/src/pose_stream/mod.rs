//! Poses as lines of JSON, as they come in.

mod bone_json;
mod read;
mod write;

pub(crate) use bone_json::{bone_pose, numbers};
pub use read::{PoseParser, PoseReader};
pub use write::{clip_as_poses, pose_header_line, pose_line};
