//! What is baked: a skin on bones, with or without the mesh of its soft layer.

mod attachment;
#[allow(clippy::module_inception)]
mod body;
mod limb;
mod parametric;

pub use attachment::Attachment;
pub use body::{Body, LayerMesh};
pub use limb::{Limb, one_bone_body};
pub use parametric::{Joints, ParametricModel};
