//! Streams of Draco behind the primitive of a glTF file.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|stream: &[u8]| {
    let length = stream.len();
    let mut json = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{{\"mesh\":0}}],\"meshes\":[{{\"primitives\":[{{\
         \"attributes\":{{\"POSITION\":0,\"TEXCOORD_0\":1}},\"extensions\":{{\"KHR_draco_mesh_compression\":{{\"bufferView\":0,\
         \"attributes\":{{\"POSITION\":0,\"TEXCOORD_0\":3}}}}}}}}]}}],\"accessors\":[{{\"componentType\":5126,\"type\":\"VEC3\",\"count\":82}},\
         {{\"componentType\":5126,\"type\":\"VEC2\",\"count\":82}}],\"buffers\":[{{\"byteLength\":{length}}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteLength\":{length}}}],\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]}}",
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
