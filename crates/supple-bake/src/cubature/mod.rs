//! Data-oblivious cubature: points and positive weights (method §3).

#[allow(clippy::module_inception)]
mod cubature;
mod points;
mod prior;
mod weights;

pub(crate) use points::candidates;

pub use cubature::{Cubature, CubatureMethod, CubatureReport, Sampling, Tissue, Weights};
