//! Offline: body → mesh → basis → cubature → one baked avatar.
//!
//! The phases in the order in which [`bake()`] strings them together by a [`Recipe`]: a [`Body`] gets the mesh of its soft
//! layer ([`mesh`]), skin weights inside it (`interior`), [handles](Handles) and their biharmonic basis (`basis`),
//! cubature points and weights (`cubature`), values at the points, and bone masses (`bones`). [`full_space`] and
//! [`subspace`] are the same body in other spaces, for comparison.

mod attached;
#[allow(clippy::module_inception)]
mod bake;
mod basis;
mod body;
mod bones;
mod contact_stiffness;
mod cubature;
mod depth;
mod file;
mod fine;
mod full_space;
mod handles;
mod interior;
mod local_tissue;
pub mod math;
pub mod mesh;
mod pose_extension;
mod recipe;
mod report;
mod softness;
pub mod subspace;
mod sway;

pub use bake::{PHASES, Progress, bake};
pub use basis::{BasisEnergy, BiharmonicSystem, Constraints, Truncation, biharmonic_energy};
pub use body::{
    Attachment, Body, BodyPart, Finger, Joints, LayerMesh, Limb, ParametricModel, Part, Side,
    body_parts, one_bone_body, plain_name, skeleton_parts,
};
pub use bones::{BoneMassReport, JointLimitKey, SpringReport, bone_masses, set_limits};
pub use cubature::{Cubature, CubatureMethod, CubatureReport, Sampling, Tissue, Weights};
pub use depth::ThinPlace;
pub use file::{Baked, baked_file, from_bytes, read_baked, to_bytes, write_baked};
pub use fine::{FineExtension, FineRecipe, FineReport};
pub use full_space::{SparseCholesky, all_tets, full_space, full_space_simulation, without_tissue};
pub use handles::{
    Density, HandleCandidates, HandleRegion, Handles, Softness, farthest_points,
    weighted_farthest_points,
};
pub use interior::InteriorField;
pub use local_tissue::StiffnessRegion;
pub use mesh::Mesher;
pub use recipe::{CubatureRecipe, Recipe};
pub use report::{AttachmentReport, BakeCost, BakeReport, BasisReport, HandleReport};
pub use softness::{BodyRegion, RegionReport, SoftnessRegion};
pub use supple::{Error, Result};
pub use sway::{RestSystem, full_compliance, sway_frequency};

#[cfg(test)]
pub(crate) mod test_mesh;
