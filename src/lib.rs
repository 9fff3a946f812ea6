//! Real-time soft tissue for skinned avatars.
//!
//! `supple` keeps the data-driven skinned shape of a character exactly while nothing touches it, and
//! deforms, jiggles and pushes back on the skeleton when something does. The method is that of Tapia,
//! Romero, Pérez and Otaduy, *Parametric Skeletons with Reduced Soft-Tissue Deformations* (2021).
//!
//! # Architecture
//!
//! **Constant and changing things are different types.** A [`model::Avatar`] is baked once, by the crate `supple-bake`,
//! read from a file ([`file::read_avatar`]) and never changes; a [`model::State`] holds what moves: a rigid frame for each
//! bone and a displacement φ for each handle, in f64. [`model::Space`] numbers the degrees of freedom.
//!
//! **A step minimises one incremental potential** (backward Euler). [`sim::Simulation`] predicts, and its Newton iteration
//! asks [`potential::Potential`] for a batch of energies, gradients and packed Hessians. Two implementations answer:
//! [`potential::CpuPotential`] in f64, and `potential::GpuPotential` in WGSL on the host's own device. The bones' own
//! energies ([`skeleton`]) are added in f64, and the small dense system is solved by faer.
//!
//! **The stages of an evaluation have one name everywhere**: `pose_blend`, `displacement`, `elasticity`, `contact`,
//! `select`, `friction`, `compact`, `gradient`, `point_hessian`, `hessian`, `energy`, and for the posed skin `skin` and `normals`.
//! Stage x is `kernels/x.wgsl`, its host side `src/potential/gpu/x.rs`, its twin `src/potential/cpu/x.rs`. Twins are
//! written independently and compared from the same inputs.
//!
//! **A new material or collider** is one file in [`material`] or [`collider`], one kernel of the same name, and one line in
//! a list that tests and kernels loop over.
//!
//! Imports run downward only (a test reads them):
//!
//! | rank | modules | what lives there |
//! |---|---|---|
//! | 0 | [`error`], `field_path`, `math`, `gpu` | plumbing that knows no physics |
//! | 1 | [`model`], [`material`], [`collider`] | what an avatar is, what it is made of, what it touches |
//! | 2 | [`file`](mod@file), [`potential`], [`skeleton`], `random_avatar` | the baked file, the tissue's energy and its two evaluations, the bones' own energies |
//! | 3 | [`sim`] | the step |
//! | 4 | [`world`] | avatars of several assets, colliders and bodies together |
//! | 5 | `internal` | what this workspace's own crates and tests use besides |
//!
//! # Units and conventions
//!
//! SI everywhere: m, kg, s, Pa, rad. Positions are in world space unless a name says unposed (the
//! GPU's skin buffer alone is relative to `potential::GpuPotential::skin_origin`). A rotation moves by a left increment, R ← exp(\[δω\]) R. Triangles are counter-clockwise from outside.

#![cfg_attr(docsrs, feature(doc_cfg))]

pub mod collider;
pub mod error;
mod field_path;
pub mod file;
#[cfg(feature = "gpu")]
pub mod gpu;
#[doc(hidden)]
pub mod internal;
pub mod material;
mod math;
pub mod model;
pub mod potential;
mod random_avatar;
pub mod sim;
pub mod skeleton;
pub mod world;

pub use error::{Error, GpuError, Result};
pub use field_path::FieldPath;
pub use glam;
#[cfg(feature = "gpu")]
pub use wgpu;
pub use world::World;

/// The README's example compiles.
#[cfg(all(doctest, feature = "gpu"))]
#[doc = include_str!("../README.md")]
struct Readme;
