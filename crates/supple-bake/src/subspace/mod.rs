//! Other spaces for the tissue's displacement than the biharmonic handles.
//!
//! A [`Subspace`] gives every node of the layer a 3×3 block N_h for each of its handles: u = Σ_h N_h φ_h. Two
//! are made here, for comparison and for the offline f64 evaluation only: the modal basis ([`modal`]), whose
//! vibrations are global, and the elastic extension ([`elastic_extension`]), which carries a handle's part of
//! the skin into the depth as an elastic body would. [`harmonic_extension`] is the scalar one between them.
//!
//! ```no_run
//! # fn main() -> supple::Result<()> {
//! # use supple::sim::Settings;
//! # use supple_bake::{Truncation, subspace};
//! # let avatar: supple::model::Avatar = unimplemented!();
//! let space = subspace::elastic_extension(&avatar, Truncation::OFF)?;
//! let mut simulation = space.simulation(1, Settings::default())?;
//! simulation.step_blocking()?;
//! # Ok(())
//! # }
//! ```

mod elastic_extension;
mod harmonic_extension;
mod linear_elasticity;
mod modal;
#[allow(clippy::module_inception)]
mod subspace;
#[cfg(test)]
mod test_body;

pub use elastic_extension::elastic_extension;
pub(crate) use elastic_extension::{ElasticExtension, by_node};
pub use harmonic_extension::harmonic_extension;
pub use linear_elasticity::{lumped_mass, rest_stiffness};
pub use modal::{Modes, modal};
pub use subspace::Subspace;
