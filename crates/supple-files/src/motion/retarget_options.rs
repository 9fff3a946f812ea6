//! What a [`Retarget`](super::Retarget) goes by: the motion's skeleton, and choices.

use super::bone_map::MapOptions;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use supple::model::UpAxis;

/// How the rest pose of a motion is brought to the avatar's bind pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Align {
    /// Limbs, feet and fingers point the same way in both: a T pose drives an A pose. Pelvis, spine, neck,
    /// head and collar bones keep the avatar's own posture.
    #[default]
    Directions,
    /// Both rest poses are the same, but for one rotation of the whole.
    None,
}

/// What guides a [`Retarget`](super::Retarget).
#[derive(Clone, Debug, PartialEq)]
pub struct RetargetOptions {
    /// Which bone drives which.
    pub map: MapOptions,
    /// How rest poses are aligned.
    pub align: Align,
    /// Metres of the avatar's way for one of the motion's; the ratio of the legs' lengths (of the spread
    /// of the mapped joints, if there are no legs) if not given.
    pub scale: Option<f64>,
    /// The axis that points up in the avatar's reference shape; as the motion's rest pose has it if not given.
    pub avatar_up: Option<UpAxis>,
    /// The direction that points up in the avatar's world; a unit vector.
    pub up: DVec3,
}

impl Default for RetargetOptions {
    fn default() -> Self {
        Self {
            map: MapOptions::default(),
            align: Align::default(),
            scale: None,
            avatar_up: None,
            up: DVec3::Z,
        }
    }
}

/// The skeleton that a motion was recorded on.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SourceSkeleton {
    /// Names of its bones.
    pub names: Vec<String>,
    /// Each joint's place in the rest pose, m, where it is known.
    pub rest_joints: Vec<Option<DVec3>>,
    /// The axis that points up in the rest pose; `None` if nothing is known of it.
    pub rest_up: Option<UpAxis>,
    /// The axis that points up in the world of the motion; `None` if that is the avatar's world.
    pub world_up: Option<UpAxis>,
}
