//! Where handles stand: chosen by a recipe's regions or by the tissue's softness.

pub(crate) mod automatic;
pub(crate) mod candidates;
#[allow(clippy::module_inception)]
mod handles;
mod mirror;
mod sampling;
mod softness;

pub use handles::{HandleCandidates, HandleRegion, Handles};
pub use sampling::{Density, farthest_points, weighted_farthest_points};
pub use softness::Softness;
pub(crate) use softness::upper_quantile;
