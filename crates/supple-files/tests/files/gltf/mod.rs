//! glTF and VRM in: every feature against an evaluation of its own, made from the file's JSON alone.

mod assets;
mod attachments;
mod damaged;
mod evaluation;
mod fixture;
mod joints;
mod malformed;
mod meshes;
mod motions;
mod parts;
mod skins;
mod vrm;
