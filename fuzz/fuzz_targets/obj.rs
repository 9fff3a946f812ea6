//! Wavefront OBJ.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let _ = supple_files::parse_obj(bytes, Path::new("fuzz"));
});
