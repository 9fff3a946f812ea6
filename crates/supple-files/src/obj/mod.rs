//! Wavefront OBJ: surfaces by name.

mod read;
mod write;

pub use read::{parse_obj, read_closed_obj, read_obj};
pub use write::write_obj;
