//! Every format read and written, and damaged.

mod formats;
mod fuzz_corpus;
mod glb;
mod gltf;
mod motion;
#[path = "../../../../tests/engine/support.rs"]
mod support;
mod tet_files;
