//! TetGen's three files, cut at `%`.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let mut files = bytes.split(|b| *b == b'%');
    let [nodes, tets, faces] = [(); 3].map(|()| files.next().unwrap_or_default());
    let _ = supple_files::parse_tetgen(nodes, tets, Some(faces), Path::new("fuzz"));
});
