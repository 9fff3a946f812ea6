//! What is baked: a skin on bones, with or without the mesh of its soft layer.

mod attachment;
#[allow(clippy::module_inception)]
mod body;
mod bone_names;
mod limb;
mod parametric;

pub use attachment::Attachment;
pub use body::{Body, LayerMesh};
pub use bone_names::{BodyPart, Finger, Part, Side, body_parts, plain_name, skeleton_parts};
pub use limb::{Limb, one_bone_body};
pub use parametric::{Joints, ParametricModel};
