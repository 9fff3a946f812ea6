//! Gmsh, Medit and the plain text of tets, and what is made of the mesh.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::collections::BTreeMap;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(file) = supple_files::parse_tets(bytes, Path::new("fuzz")) {
        let _ = file.body("fuzz", &BTreeMap::new());
        let _ = file.layer(&["wrist".into()], &BTreeMap::new());
    }
});
