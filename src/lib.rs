//! Real-time soft tissue for skinned avatars.
//!
//! `supple` keeps the data-driven skinned shape of a character exactly while nothing touches it, and
//! deforms, jiggles and pushes back on the skeleton when something does.
//!
//! # Architecture
//!
//! The folders read in the order the data flows, and imports run downward only:
//!
//! | rank | modules | what lives there |
//! |---|---|---|
//! | 0 | [`error`], [`math`], `gpu` | plumbing that knows no physics |
//! | 1 | [`model`], [`material`], [`collider`] | what an avatar is, what it is made of, what it touches |
//! | 2 | [`potential`] | the interface between Newton and the two evaluations of the energy |
//! | 3 | [`reference`](mod@reference), `stage`, [`skeleton`] | the f64 evaluation, the WGSL evaluation, the bones' own energies |
//! | 4 | [`load`], [`sample`], [`bake`], [`sim`] | files in, generated models, offline precomputation, the step |
//! | 5 | [`export`] | pictures, GLB, reports out |
//! | 6 | `cli` | the command |
#![warn(missing_docs)]

pub mod bake;
#[cfg(feature = "cli")]
pub mod cli;
pub mod collider;
pub mod error;
pub mod export;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod load;
pub mod material;
pub mod math;
pub mod model;
pub mod potential;
pub mod reference;
pub mod sample;
pub mod sim;
pub mod skeleton;
#[cfg(feature = "gpu")]
pub mod stage;

pub use error::{Error, GpuError, Result};
pub use glam;
#[cfg(feature = "gpu")]
pub use wgpu;
