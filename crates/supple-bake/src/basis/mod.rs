//! The sparse biharmonic basis of the handles (method §2).

mod biharmonic;
mod biharmonic_energy;
mod held_nodes;
mod many_columns;
mod points;
mod truncation;

pub use biharmonic::{BiharmonicSystem, Constraints};
pub(crate) use biharmonic::{gather, scatter};
pub(crate) use biharmonic_energy::interior_faces;
pub use biharmonic_energy::{BasisEnergy, biharmonic_energy};
pub(crate) use held_nodes::{HeldNodes, Role};
pub(crate) use many_columns::ManyColumns;
pub(crate) use points::{
    basis_at_tets, basis_on_skin, largest_weights, rows_through, skinning_at_tets,
};
pub use truncation::Truncation;
