//! glTF and VRM in: every feature against an evaluation of its own, made from the file's JSON alone.

mod assets;
mod attachments;
mod bones;
mod cases;
mod damaged;
mod evaluation;
mod fixture;
mod joints;
mod malformed;
mod meshes;
mod motions;
mod parts;
mod scales;
mod skins;
mod springs;
mod vrm;
