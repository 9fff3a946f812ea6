//! What an avatar is: plain data, no algorithms beyond its own geometry.

mod appearance;
mod avatar;
mod bone_mass;
mod follow;
mod frame;
mod joint_range;
mod joints;
mod points;
mod pose_offsets;
mod render_mesh;
mod rigid_body;
pub(crate) mod skeleton;
mod spring_bones;
mod state;
mod surface;
mod tet_mesh;
mod up_axis;

pub use appearance::{Appearance, Image};
pub use avatar::{Avatar, SoftLayer};
pub use bone_mass::BoneMass;
pub use frame::Frame;
pub(crate) use frame::is_rotation;
pub use joint_range::JointRange;
pub use joints::{Joint, JointBone, JointList, SkinJoints};
pub use points::{BasisEntry, PointSet, PoseBlend, SkinWeight};
pub(crate) use pose_offsets::OffsetLimits;
pub use pose_offsets::PoseOffsets;
pub use render_mesh::RenderMesh;
pub use rigid_body::RigidBody;
pub use skeleton::Skeleton;
pub(crate) use skeleton::{pose_feature, pose_feature_into, pose_features};
pub use spring_bones::{SpringBones, SpringChain, SpringCollider, SpringJoint};
pub use state::{Space, State};
pub use surface::Surface;
pub use tet_mesh::TetMesh;
pub use up_axis::UpAxis;
