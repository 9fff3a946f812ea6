//! Streams of Draco behind the primitive of a glTF file.
#![no_main]

#[path = "../glb.rs"]
mod glb;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|stream: &[u8]| {
    let length = stream.len();
    let json = format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scenes\":[{{\"nodes\":[0]}}],\"nodes\":[{{\"mesh\":0}}],\"meshes\":[{{\"primitives\":[{{\
         \"attributes\":{{\"POSITION\":0,\"TEXCOORD_0\":1}},\"extensions\":{{\"KHR_draco_mesh_compression\":{{\"bufferView\":0,\
         \"attributes\":{{\"POSITION\":0,\"TEXCOORD_0\":3}}}}}}}}]}}],\"accessors\":[{{\"componentType\":5126,\"type\":\"VEC3\",\"count\":82}},\
         {{\"componentType\":5126,\"type\":\"VEC2\",\"count\":82}}],\"buffers\":[{{\"byteLength\":{length}}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteLength\":{length}}}],\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]}}",
    );
    let _ = supple_files::parse_gltf(&glb::of(json, stream), "nowhere/fuzz");
});
