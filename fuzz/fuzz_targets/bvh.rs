//! BVH.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;
use supple_files::{BvhOptions, parse_bvh};

fuzz_target!(|bytes: &[u8]| {
    let text = String::from_utf8_lossy(bytes);
    let _ = parse_bvh(&text, Path::new("fuzz"), &BvhOptions::default());
});
