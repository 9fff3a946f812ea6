//! Every format read and written, and damaged.

#[cfg(feature = "draco")]
mod draco_file;
mod formats;
mod fuzz_corpus;
mod glb;
mod gltf;
mod meshopt_encoder;
mod motion;
#[path = "../../../../tests/engine/support.rs"]
mod support;
mod tet_files;
