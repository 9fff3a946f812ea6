//! Motions in: one file a format.

mod amass;
mod bone_json;
mod bvh;
mod hand_pose;
mod js_literal;
mod playback;
mod pose_stream;
mod tracked;
mod unit;

pub use amass::{parse_amass, read_amass};
pub use bvh::{BvhOptions, parse_bvh, read_bvh};
pub use hand_pose::{parse_pose, read_pose};
pub use playback::{Playback, PoseFeed, read_motion};
pub use pose_stream::{PoseParser, PoseReader};
pub use tracked::{RootTracking, TrackedMotion};
pub use unit::Unit;
