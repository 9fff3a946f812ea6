//! Streams of meshopt behind the view of a glTF file: the first byte says which mode and filter.
#![no_main]

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
    let mut json = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{{\"mesh\":0}}],\"meshes\":[{{\"primitives\":[{{\
         \"attributes\":{{\"POSITION\":0}}}}]}}],\"accessors\":[{{\"bufferView\":0,\"componentType\":5121,\"type\":\"VEC3\",\"count\":{}}}],\
         \"buffers\":[{{\"byteLength\":{}}},{{\"byteLength\":{length}}}],\"bufferViews\":[{{\"buffer\":1,\"byteLength\":{length},\
         \"extensions\":{{\"KHR_meshopt_compression\":{{\"buffer\":0,\"byteLength\":{},\"byteStride\":{stride},\"count\":{count},\
         \"mode\":\"{mode}\",\"filter\":\"{filter}\"}}}}}}]}}",
        length / 3,
        stream.len(),
        stream.len(),
    )
    .into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut binary = stream.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", binary)] {
        glb.extend((chunk.len() as u32).to_le_bytes());
        glb.extend(kind);
        glb.extend(chunk);
    }
    let _ = supple_files::parse_gltf(&glb, "nowhere/fuzz");
});
