//! AMASS.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let _ = supple_files::parse_amass(bytes, Path::new("fuzz"));
});
