//! SMPL's family: `.npz` archives, and pickles where the bytes do not begin as an archive.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let _ = supple_files::parse_smpl(bytes, Path::new("fuzz"));
});
