//! glTF 2.0 (`.glb`, `.gltf`) and VRM 0.x and 1.0 (`.vrm`).
//!
//! The body is in the scene's own coordinates: m, y up, at rest where the file shows it. Nothing in
//! a file is trusted: every count, offset and index is checked before it is used.

mod accessor;
mod assemble;
mod character;
mod container;
mod document;
mod nodes;
mod primitive;
mod rig;
mod vrm;
mod webxr;

pub use character::{Character, Shape};

use crate::Result;
use container::File;
use std::path::Path;

/// Reads the character in the glTF or VRM file at `path`.
///
/// # Errors
/// [`crate::Error::Io`] where a file cannot be read; [`crate::Error::Format`], naming the object at
/// fault, where it is broken, requires an extension that is not read (mesh compression), or holds bones
/// that are sheared or scaled differently along their axes.
pub fn read_gltf(path: impl AsRef<Path>) -> Result<Character> {
    assemble::character(&File::read(path.as_ref())?)
}

/// [`read_gltf`] of a file's `bytes`; buffers outside of it lie relative to `path`, which also names it in
/// errors.
///
/// # Errors
/// As [`read_gltf`].
pub fn parse_gltf(bytes: &[u8], path: impl AsRef<Path>) -> Result<Character> {
    assemble::character(&File::parse(bytes, path.as_ref())?)
}
