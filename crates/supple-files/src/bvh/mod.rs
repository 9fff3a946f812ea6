//! BVH: a skeleton in offsets, and its motion.

mod read;
mod write;

pub use read::{BvhOptions, parse_bvh, read_bvh};
pub use write::{bvh_text, write_bvh};
