//! Offline: mesh → basis → cubature → one baked avatar.

mod biharmonic;
pub mod mesh;

pub use biharmonic::{BiharmonicSystem, Constraints, biharmonic_energy};

#[cfg(test)]
mod test_mesh;
