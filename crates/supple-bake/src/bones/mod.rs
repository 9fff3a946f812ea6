//! Bones: their masses, and how far joints turn.

mod bone_mass;
mod core_volume;
mod limits;
mod loads;
mod springs;

pub use bone_mass::{BoneMassReport, bone_masses};
pub use limits::{JointLimitKey, set_limits};
pub(crate) use loads::{BoneLoads, drop_bones, retain};
pub use springs::SpringReport;
pub(crate) use springs::left_to_tissue;
