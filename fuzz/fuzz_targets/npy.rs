//! A `.npy` array, in an archive that is sound.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let _ = supple_files::parse_amass(&archive("poses.npy", bytes), Path::new("fuzz"));
});

/// A zip archive of one member that is stored as it is: local header, member, directory, its end.
fn archive(name: &str, member: &[u8]) -> Vec<u8> {
    let (size, sum) = (member.len() as u32, crc32fast::hash(member));
    let mut sizes = vec![20, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    for number in [sum, size, size, name.len() as u32] {
        sizes.extend(number.to_le_bytes());
    }
    let local = [b"PK\x03\x04", &sizes[..], name.as_bytes(), member].concat();
    let entry = [b"PK\x01\x02\x14\0", &sizes[..], &[0; 14], name.as_bytes()].concat();
    let mut end = b"PK\x05\x06\0\0\0\0\x01\0\x01\0".to_vec();
    end.extend((entry.len() as u32).to_le_bytes());
    end.extend((local.len() as u32).to_le_bytes());
    end.extend([0, 0]);
    [local, entry, end].concat()
}
