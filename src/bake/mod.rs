//! Offline: mesh → basis → cubature → one baked avatar.
//!
//! The phases, each a file: skin weights inside the layer (`interior`), handles (`handles`) and their
//! biharmonic basis (`biharmonic_energy`, `biharmonic`, `truncation`), cubature (`cubature` and its files), values at the points
//! (`points`), bone masses (`bone_mass`). [`bake`] strings them together by a [`Recipe`], and `file`
//! keeps the result.

mod attached;
mod automatic;
#[allow(clippy::module_inception)]
mod bake;
mod biharmonic;
mod biharmonic_energy;
mod bone_mass;
mod core_volume;
mod cubature;
mod cubature_points;
mod cubature_prior;
mod cubature_weights;
mod file;
mod full_space;
mod handle_candidates;
mod handles;
mod held_nodes;
mod interior;
mod limits;
mod local_tissue;
mod loose_parts;
pub mod mesh;
mod mesher;
mod points;
mod recipe;
mod report;
mod sampling;
mod softness;
mod truncation;

pub use bake::{PHASES, Progress, bake};
pub use biharmonic::{BiharmonicSystem, Constraints};
pub use biharmonic_energy::{BasisEnergy, biharmonic_energy};
pub use bone_mass::{BoneMassReport, bone_masses};
pub use cubature::{Cubature, CubatureMethod, CubatureReport, Sampling, Tissue, Weights};
pub use file::{Baked, from_bytes, read_avatar, read_baked, to_bytes, write_avatar, write_baked};
pub use full_space::{all_tets, full_space, without_tissue};
pub use handles::{HandlePlace, HandleRegion, Handles};
pub(crate) use held_nodes::{HeldNodes, Role};
pub use interior::InteriorField;
pub use limits::{JointLimitKey, set_limits};
pub use local_tissue::StiffnessRegion;
pub use mesher::Mesher;
pub(crate) use points::{basis_at_tets, basis_on_skin, rows_through};
pub use recipe::{CubatureRecipe, Recipe};
pub use report::{AttachmentReport, BakeCost, BakeReport, BasisReport, HandleReport};
pub use sampling::{Density, farthest_points, weighted_farthest_points};
pub use softness::Softness;
pub use truncation::Truncation;

#[cfg(test)]
pub(crate) mod test_mesh;
