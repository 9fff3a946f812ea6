//! Fine handles: columns that sleep beside the coarse ones until something comes near (`supple::model::FineHandles`).

mod cells;
#[allow(clippy::module_inception)]
mod fine;
mod places;
mod recipe;

pub use fine::FineReport;
pub(crate) use fine::{Coarse, bake_fine};
pub use recipe::{FineExtension, FineRecipe};
