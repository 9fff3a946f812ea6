//! Recorded and live motion on an avatar's skeleton: bones mapped by name, rest poses aligned, the way
//! over the ground scaled and placed, frames for every time step.

mod bone_map;
mod clip_player;
mod cubic;
pub(crate) mod figure;
mod fit;
mod ground;
mod mirror;
mod motion_clip;
mod pose;
mod pose_player;
mod rest_fit;
mod retarget;
mod retarget_options;
mod slides;
pub mod smpl;
mod unit;

pub use bone_map::{BoneMap, MapOptions};
pub use clip_player::{ClipOptions, ClipPlayer, Origin, blend};
pub use mirror::{mirrored_clip, mirrored_header, mirrored_poses};
pub use motion_clip::{MotionClip, MotionFrame};
pub use pose::{BonePose, BonePoses, PoseHeader};
pub use pose_player::{NextPose, PoseOptions, PosePlayer};
pub use retarget::Retarget;
pub use retarget_options::{Align, RetargetOptions, SourceSkeleton};
pub use supple_bake::{BodyPart, Finger, Part, Side, body_parts};
pub use unit::Unit;
