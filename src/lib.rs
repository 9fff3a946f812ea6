//! Real-time soft tissue for skinned avatars.
//!
//! `supple` keeps the data-driven skinned shape of a character exactly while nothing touches it, and
//! deforms, jiggles and pushes back on the skeleton when something does. The method is that of Tapia,
//! Romero, Pérez and Otaduy, *Parametric Skeletons with Reduced Soft-Tissue Deformations* (2021).
//!
//! ```
//! use supple::{World, world::Backend};
//! # use supple::{file::{AvatarFile, Parts}, glam::Mat4};
//! # fn main() -> supple::Result<()> {
//! # let path = std::env::temp_dir().join(format!("front_page_{}.supple", std::process::id()));
//! # let random = supple::internal::random_avatar(1, 3, 4, 20, 40);
//! # let mut matrices: Vec<Mat4> = Vec::new();
//! # random.joints.joint_matrices(&random.rest_state().frames, &mut matrices)?;
//! # AvatarFile::new(random).write(Parts::All, &path)?;
//! let mut world = World::new(Backend::Auto)?; // a GPU if there is one, else the CPU; y points up
//! let hand = world.add_avatar(supple::file::read_avatar(&path)?)?; // once for all its instances
//! let left = world.add_instance(hand)?; // springs keep its pose; it starts where the first bones are
//! let (mut positions, mut normals) = (Vec::new(), Vec::new());
//! for _frame in 0..3 {
//!     // World matrices of the file's joints, which `avatar().joints` lists in this order.
//!     world.instance_mut(left)?.follow_world(&matrices)?;
//!     world.step_blocking(1.0 / 60.0)?; // or step(dt).await
//!     world.read_skin_blocking(left, &mut positions, &mut normals)?; // or draw from skin_buffer(left)
//! }
//! # std::fs::remove_file(path).map_err(|e| supple::Error::io("front_page", e))?;
//! # Ok(())
//! # }
//! ```
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
//! **A world is many simulations in one.** [`World`] holds avatars of any assets, rigid bodies and colliders; a body is an
//! avatar of one bone. What touches a common body is one group, whose linear system is solved by eliminating its members in
//! parallel; [`sim::Simulation`] is the layer below, for one asset and a potential of one's own.
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
