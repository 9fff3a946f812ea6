//! How soft a body's tissue is, region by region, and for how long it rings.
//!
//! A recipe names the first frequency or the shear modulus of a region ([`SoftnessRegion`]); what it leaves open, people's
//! own softness fills where the bones' names tell a person ([`BodyRegion`]), and a rule by depth elsewhere. Frequencies are
//! those of the reduced tissue ([`crate::RestSystem`]).

mod person;
mod recipe;
mod regions;
mod report;

pub use person::BodyRegion;
pub(crate) use person::Person;
pub use recipe::SoftnessRegion;
pub(crate) use regions::{Regions, validate};
pub use report::RegionReport;
