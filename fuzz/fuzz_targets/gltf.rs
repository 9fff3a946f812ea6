//! glTF and VRM: the body and the animations.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(character) = supple_files::parse_gltf(bytes, "nowhere/fuzz") {
        let _ = character.body(&[0.5]);
    }
    let _ = supple_files::parse_gltf_motions(bytes, "nowhere/fuzz");
});
