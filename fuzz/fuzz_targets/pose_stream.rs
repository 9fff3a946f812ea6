//! Poses as JSON lines.
#![no_main]

use libfuzzer_sys::fuzz_target;
use supple_files::PoseReader;

fuzz_target!(|bytes: &[u8]| {
    let mut reader = PoseReader::new(bytes, "fuzz");
    while let Ok(Some(_)) = reader.next_pose() {}
});
