//! Scenes and recipes.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(text) = std::str::from_utf8(bytes) {
        let _ = supple_scene::parse_scene(text, Path::new("fuzz"));
        let _ = supple_scene::parse_avatar_source(text, Path::new("fuzz"));
    }
});
