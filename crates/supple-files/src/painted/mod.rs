//! Maps painted on a skin: a number for each vertex.

mod read;
mod write;

pub use read::read_painted;
pub use write::write_painted;
