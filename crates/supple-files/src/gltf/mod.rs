//! glTF 2.0 (`.glb`, `.gltf`), VRM 0.x and 1.0 (`.vrm`), and VRM animations (`.vrma`).
//!
//! The body is in the scene's own coordinates: m, y up, at rest where the file shows it. Nothing in
//! a file is trusted: every count, offset and index is checked before it is used.

mod accessor;
mod animation;
mod appearance;
mod assemble;
mod binding;
mod bone_nodes;
mod bone_tree;
mod character;
mod compression;
mod container;
mod document;
mod joints;
mod motion_bones;
mod nodes;
mod polar;
mod primitive;
mod reference_part;
mod rig;
mod sampler;
mod springs;
mod told_springs;
mod triangles;
mod vrm;
mod webxr;
pub mod write;

pub use character::{Character, Shape};

use crate::motion::MotionClip;
use assemble::Scene;
use container::File;
use nodes::Nodes;
use std::path::Path;
use supple::Result;

/// Reads the character in the glTF or VRM file at `path`.
///
/// # Errors
/// [`supple::Error::Io`] where a file cannot be read; [`supple::Error::Format`], naming the object at
/// fault, where it is broken, requires an extension that may change geometry and is not read (mesh compression), or shows
/// no triangles.
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

/// Reads the animations in the glTF, VRM or VRMA file at `path` as motions of bones away from the reference shape.
///
/// Bones are those of the character, if the scene shows one, all nodes that an animation turns or shifts, and those between;
/// of a file without a skin all nodes of the trees that are moved; of a VRM animation the humanoid ones, by VRM's names.
/// Animations that have keys for none of them are left out, and so are keys of scales, which [`MotionClip::notes`] tell.
///
/// # Errors
/// As [`read_gltf`], but a file need not show anything; [`supple::Error::Format`] naming the animation where it is too
/// long for its number of bones.
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

/// Whether the glTF file at `path` is a motion and no character: it holds animations, and its scene shows no mesh.
///
/// # Errors
/// As [`read_gltf`], of the file and its nodes.
pub fn is_gltf_motion(path: impl AsRef<Path>) -> Result<bool> {
    let file = File::read(path.as_ref())?;
    let nodes = Nodes::read(&file)?;
    let mut drawn = file.document.nodes.iter().zip(&nodes.shown);
    let shows_mesh = drawn.any(|(node, shown)| *shown && node.mesh.is_some());
    Ok(!shows_mesh && !file.document.animations.is_empty())
}
