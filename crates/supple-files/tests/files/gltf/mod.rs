//! glTF and VRM in: every feature against an evaluation of its own, made from the file's JSON alone.

mod assets;
mod attachments;
mod bones;
mod cases;
mod damaged;
#[cfg(feature = "draco")]
mod draco;
mod evaluation;
pub mod fixture;
mod images;
mod joints;
mod malformed;
pub mod materials;
mod meshes;
pub mod meshopt;
mod motions;
mod parts;
mod scales;
mod skins;
mod springs;
mod vrm;
