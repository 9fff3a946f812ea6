//! Baked avatars: sections behind a header whose length and checksum are right.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    // The header is the table in src/file/mod.rs.
    let version = 4u32.to_le_bytes();
    let length = (bytes.len() as u64).to_le_bytes();
    let sum = crc32fast::hash(&[&version[..], &length, bytes].concat()).to_le_bytes();
    let file = [&b"SUPPLE\r\n"[..], &version, &sum, &length, bytes].concat();
    let _ = supple_bake::from_bytes(&file, Path::new("fuzz"));
});
