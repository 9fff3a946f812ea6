//! glTF 2.0 (`.glb`, `.gltf`) and VRM 0.x and 1.0 (`.vrm`).
//!
//! The body is in the scene's own coordinates: m, y up, at rest where the file shows it. Nothing in
//! a file is trusted: every count, offset and index is checked before it is used.

mod accessor;
mod animation;
mod assemble;
mod bone_tree;
mod character;
mod container;
mod document;
mod joints;
mod nodes;
mod primitive;
mod reference_part;
mod rig;
mod sampler;
mod triangles;
mod vrm;
mod webxr;
pub mod write;

pub use character::{Character, Shape};
pub use vrm::BoneCollider;

use crate::motion::MotionClip;
use assemble::Scene;
use container::File;
use std::path::Path;
use supple::Result;

/// Reads the character in the glTF or VRM file at `path`.
///
/// # Errors
/// [`supple::Error::Io`] where a file cannot be read; [`supple::Error::Format`], naming the object at
/// fault, where it is broken, requires an extension that is not read (mesh compression), or holds bones
/// that are sheared or scaled differently along their axes.
pub fn read_gltf(path: impl AsRef<Path>) -> Result<Character> {
    Scene::new(&File::read(path.as_ref())?)?.character()
}

/// [`read_gltf`] of a file's `bytes`; buffers outside of it lie relative to `path`, which also names it in
/// errors.
///
/// # Errors
/// As [`read_gltf`].
pub fn parse_gltf(bytes: &[u8], path: impl AsRef<Path>) -> Result<Character> {
    Scene::new(&File::parse(bytes, path.as_ref())?)?.character()
}

/// Reads the animations in the glTF or VRM file at `path` as motions of its bones away from the
/// reference shape; animations that move no bone are left out.
///
/// # Errors
/// As [`read_gltf`], and [`supple::Error::Format`] naming animation, bone and time where a bone's scale
/// changes or a bone is sheared.
pub fn read_gltf_motions(path: impl AsRef<Path>) -> Result<Vec<MotionClip>> {
    Scene::new(&File::read(path.as_ref())?)?.motions()
}

/// [`read_gltf_motions`] of a file's `bytes`.
///
/// # Errors
/// As [`read_gltf_motions`].
pub fn parse_gltf_motions(bytes: &[u8], path: impl AsRef<Path>) -> Result<Vec<MotionClip>> {
    Scene::new(&File::parse(bytes, path.as_ref())?)?.motions()
}
