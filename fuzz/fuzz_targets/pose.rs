//! A pose in JSON or JavaScript.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = supple_files::parse_pose(text, Path::new("fuzz"));
    }
});
