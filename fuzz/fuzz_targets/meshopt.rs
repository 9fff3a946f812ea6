//! Streams of meshopt behind the view of a glTF file: the first byte says which mode and filter.
#![no_main]

#[path = "../glb.rs"]
mod glb;

use libfuzzer_sys::fuzz_target;

/// Mode, filter and bytes of an element.
const KINDS: [(&str, &str, usize); 7] = [
    ("ATTRIBUTES", "NONE", 12),
    ("ATTRIBUTES", "OCTAHEDRAL", 4),
    ("ATTRIBUTES", "QUATERNION", 8),
    ("ATTRIBUTES", "EXPONENTIAL", 12),
    ("ATTRIBUTES", "COLOR", 8),
    ("TRIANGLES", "NONE", 4),
    ("INDICES", "NONE", 2),
];

fuzz_target!(|bytes: &[u8]| {
    let Some((first, stream)) = bytes.split_first() else {
        return;
    };
    let (mode, filter, stride) = KINDS[usize::from(*first) % KINDS.len()];
    let count = 96;
    let length = count * stride;
    let json = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{{\"mesh\":0}}],\"meshes\":[{{\"primitives\":[{{\
         \"attributes\":{{\"POSITION\":0}}}}]}}],\"accessors\":[{{\"bufferView\":0,\"componentType\":5121,\"type\":\"VEC3\",\"count\":{}}}],\
         \"buffers\":[{{\"byteLength\":{}}},{{\"byteLength\":{length}}}],\"bufferViews\":[{{\"buffer\":1,\"byteLength\":{length},\
         \"extensions\":{{\"KHR_meshopt_compression\":{{\"buffer\":0,\"byteLength\":{},\"byteStride\":{stride},\"count\":{count},\
         \"mode\":\"{mode}\",\"filter\":\"{filter}\"}}}}}}]}}",
        length / 3,
        stream.len(),
        stream.len(),
    );
    let _ = supple_files::parse_gltf(&glb::of(json, stream), "nowhere/fuzz");
});
