//! Files that are broken, hostile or not readable: typed errors that name the place, never a panic.

use super::fixture::*;
use glam::DQuat;
use serde_json::{Value, json};
use std::path::Path;
use supple::Error;
use supple_files::{parse_gltf, parse_gltf_motions};

/// A file with some of everything.
pub fn rich() -> Fixture {
    let mut file = bar_file(&BarFile::default());
    let count = Bar::new(10, 0.05).positions.len();
    let moves = file.vectors(&vec![glam::DVec3::Z; count]);
    let places = file.view(&[1, 0, 2, 0]);
    let values = file.view(&[0; 24]);
    let sparse = json!({
        "componentType": FLOAT, "count": count, "type": "VEC3",
        "sparse": {
            "count": 2, "indices": {"bufferView": places, "componentType": SHORT},
            "values": {"bufferView": values},
        },
    });
    let sparse = file.push("accessors", sparse);
    let coordinates = file.floats("VEC2", &vec![[0.5; 2]; count]);
    let primitive = &mut file.json["meshes"][0]["primitives"][0];
    primitive["targets"] = json!([{"POSITION": moves}, {"POSITION": sparse}]);
    primitive["attributes"]["TEXCOORD_0"] = json!(coordinates);
    let times = file.floats("SCALAR", &[[0.0], [1.0]]);
    let turn = DQuat::from_rotation_x(0.4).as_quat().to_array();
    let turns = file.floats("VEC4", &[[0.0, 0.0, 0.0, 1.0], turn]);
    file.push(
        "animations",
        json!({
            "samplers": [{"input": times, "output": turns}],
            "channels": [{"sampler": 0, "target": {"node": 2, "path": "rotation"}}],
        }),
    );
    file.json["extensions"]["VRM"] = json!({
        "humanoid": {"humanBones": [{"bone": "hips", "node": 1}]},
        "secondaryAnimation": {"colliderGroups": [
            {"node": 2, "colliders": [{"offset": {"x": 0.01, "y": 0.02, "z": 0}, "radius": 0.05}]},
        ]},
    });
    file
}

/// Reads everything there is to read.
pub fn read(bytes: &[u8]) -> supple::Result<()> {
    let path = Path::new("folder/figure.glb");
    let body = parse_gltf(bytes, path)?.body(&[])?;
    assert!(body.skin.positions.iter().all(|p| p.is_finite()));
    parse_gltf_motions(bytes, path)?;
    Ok(())
}

/// Demands an [`Error::Format`] whose text holds all of `words`.
pub fn refused(bytes: &[u8], words: &[&str]) {
    let Err(error) = read(bytes) else {
        panic!("was read: {words:?}")
    };
    let message = error.to_string();
    assert!(matches!(error, Error::Format { .. }), "{message}");
    assert!(message.starts_with("folder/figure.glb:"), "{message}");
    for word in words {
        assert!(message.contains(word), "{word}: {message}");
    }
}

#[test]
fn the_rich_file_is_sound() {
    read(&rich().glb()).unwrap();
}

#[test]
fn broken_documents_name_the_object_at_fault() {
    let accessor = |file: &Fixture, name: &str| {
        let attributes = &file.json["meshes"][0]["primitives"][0]["attributes"];
        attributes[name].as_u64().unwrap() as usize
    };
    type Change = Box<dyn Fn(&mut Fixture)>;
    let set = |pointer: &'static str, value: Value| -> Change {
        Box::new(move |f: &mut Fixture| {
            let (parent, key) = pointer.rsplit_once('/').unwrap();
            f.json.pointer_mut(parent).unwrap()[key] = value.clone();
        })
    };
    let of = |name: &'static str, key: &'static str, value: Value| -> Change {
        Box::new(move |f: &mut Fixture| {
            let at = accessor(f, name);
            f.json["accessors"][at][key] = value.clone();
        })
    };
    let huge = json!(u64::MAX);
    let cases: Vec<(Change, &[&str])> = vec![
        (
            set("/asset/version", json!("1.0")),
            &["asset.version", "1.0"],
        ),
        (
            set("/extensionsRequired", json!(["ACME_mesh_compression"])),
            &[
                "extensionsRequired",
                "ACME_mesh_compression",
                "without compression",
            ],
        ),
        (
            set(
                "/extensionsRequired",
                json!(["KHR_materials_ior", "EXT_mesh_gpu_instancing"]),
            ),
            &["EXT_mesh_gpu_instancing", "without it"],
        ),
        (
            set("/extensionsRequired", json!(["KHR_lights_punctual_2"])),
            &["KHR_lights_punctual_2"],
        ),
        (
            set("/extensionsRequired", json!(["ACME_teapot"])),
            &["ACME_teapot"],
        ),
        (set("/scene", json!(3)), &["scene", "3"]),
        (set("/scenes/0/nodes", json!([9])), &["scenes[0]", "9"]),
        (set("/scenes/0/nodes", json!([])), &["meshes"]),
        (set("/nodes", json!(7)), &["JSON"]),
        (
            set("/nodes/3/children", json!([0])),
            &["nodes", "descendants"],
        ),
        (set("/nodes/2/children", json!([2])), &["nodes[2]", "too"]),
        (
            set("/nodes/0/children", json!([1, 4, 3])),
            &["node 3", "too"],
        ),
        (set("/nodes/0/children", json!([44])), &["nodes[0]", "44"]),
        (
            set("/nodes/1/rotation", json!([0, 0, 0, 0])),
            &["nodes[1]", "rotation"],
        ),
        (set("/nodes/1/scale", json!([0, 0, 0])), &["meshes", "flat"]),
        (
            set("/skins", json!([{"joints": []}])),
            &["primitives[0]", "no joints"],
        ),
        (
            set("/nodes/1/translation", json!([1e308, 1e308, 0])),
            &["bounds"],
        ),
        (set("/nodes/0/matrix", json!([1, 2, 3])), &["JSON"]),
        (set("/nodes/4/mesh", json!(8)), &["nodes[4].mesh", "8"]),
        (set("/nodes/4/skin", json!(8)), &["skin 8"]),
        (set("/skins/0/joints", json!([1, 2, 99])), &["joint 99"]),
        (set("/skins/0/joints", json!([1, 2])), &["joint 2 of 2"]),
        (
            set("/skins/0/inverseBindMatrices", json!(1)),
            &["accessors[1]", "MAT4"],
        ),
        (
            set("/meshes/0/primitives/0/mode", json!(9)),
            &["primitives[0]", "mode 9"],
        ),
        (
            set("/meshes/0/primitives/0/attributes", json!({})),
            &["POSITION"],
        ),
        (
            set("/meshes/0/primitives/0/indices", json!(55)),
            &["accessors[55]"],
        ),
        (
            of("POSITION", "count", json!(50_000)),
            &["accessors", "do not fit"],
        ),
        (of("POSITION", "count", huge.clone()), &["accessors"]),
        (of("POSITION", "byteOffset", huge.clone()), &["do not fit"]),
        (of("POSITION", "type", json!("VEC2")), &["VEC2", "VEC3"]),
        (of("POSITION", "componentType", json!(5124)), &["5124"]),
        (of("POSITION", "normalized", json!(true)), &["normalised"]),
        (
            of("POSITION", "bufferView", json!(77)),
            &["bufferViews[77]"],
        ),
        (of("JOINTS_0", "count", json!(5)), &["JOINTS_0", "5"]),
        (of("WEIGHTS_0", "count", huge.clone()), &["WEIGHTS_0"]),
        (of("TEXCOORD_0", "count", json!(3)), &["TEXCOORD_0"]),
        (
            set("/bufferViews/0/byteOffset", huge.clone()),
            &["bufferViews[0]"],
        ),
        (
            set("/bufferViews/0/byteLength", huge.clone()),
            &["bufferViews[0]"],
        ),
        (set("/bufferViews/0/buffer", json!(4)), &["bufferViews[0]"]),
        (set("/bufferViews/1/byteStride", json!(1)), &["every 1"]),
        (
            set("/animations/0/channels/0/sampler", json!(4)),
            &["animations[0].channels[0]", "sampler"],
        ),
        (
            set("/animations/0/channels/0/target/node", json!(44)),
            &["node"],
        ),
        (
            set(
                "/animations/0/samplers/0/interpolation",
                json!("CUBICSPLINE"),
            ),
            &["animations[0]", "number of values"],
        ),
        (
            set("/animations/0/samplers/0/interpolation", json!("MAGIC")),
            &["interpolation"],
        ),
    ];
    for (change, words) in cases {
        let mut file = rich();
        change(&mut file);
        refused(&file.glb(), words);
    }
}

#[test]
fn extensions_that_leave_geometry_alone_may_be_required() {
    let mut file = rich();
    file.json["extensionsRequired"] = json!([
        "KHR_materials_pbrSpecularGlossiness",
        "KHR_materials_variants",
        "KHR_texture_basisu",
        "EXT_texture_avif",
        "KHR_lights_punctual",
        "KHR_xmp_json_ld",
        "KHR_node_visibility",
        "KHR_mesh_quantization",
        "VRMC_vrm_animation",
    ]);
    read(&file.glb()).unwrap();
}

#[test]
fn broken_numbers_are_refused() {
    let poke = |name: &str, bytes: &[u8]| {
        let mut file = rich();
        let attributes = &file.json["meshes"][0]["primitives"][0]["attributes"];
        let accessor = attributes[name].as_u64().unwrap() as usize;
        let view = file.json["accessors"][accessor]["bufferView"]
            .as_u64()
            .unwrap();
        let at = file.json["bufferViews"][view as usize]["byteOffset"]
            .as_u64()
            .unwrap() as usize;
        file.binary[at..at + bytes.len()].copy_from_slice(bytes);
        file.glb()
    };
    refused(
        &poke("POSITION", &f32::NAN.to_le_bytes()),
        &["accessors", "not finite"],
    );
    refused(
        &poke("WEIGHTS_0", &f32::INFINITY.to_le_bytes()),
        &["not finite"],
    );
    refused(
        &poke("WEIGHTS_0", &(-0.5f32).to_le_bytes()),
        &["weight -0.5", "negative"],
    );
    refused(&poke("JOINTS_0", &[200]), &["joint 200 of 3"]);
    let mut file = rich();
    let indices = file.shorts("SCALAR", 3, &[0, 1, 9999]);
    file.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    refused(&file.glb(), &["vertex 9999"]);
}

#[test]
fn a_small_file_cannot_ask_for_much_memory() {
    // Sparse over nothing: the count is in no byte of the file.
    let mut file = rich();
    let target = &file.json["meshes"][0]["primitives"][0]["targets"][1]["POSITION"];
    let accessor = target.as_u64().unwrap() as usize;
    file.json["accessors"][accessor]["count"] = json!(2_000_000_000u64);
    file.json["meshes"][0]["primitives"][0] =
        json!({"attributes": {"POSITION": accessor}, "mode": 4});
    refused(&file.glb(), &["more numbers"]);
    // Ten thousand primitives of the same vertices.
    let mut file = rich();
    let primitive = file.json["meshes"][0]["primitives"][0].clone();
    file.json["meshes"][0]["primitives"] = json!(vec![primitive; 10_000]);
    let started = std::time::Instant::now();
    let _ = read(&file.glb());
    assert!(started.elapsed().as_secs() < 20);
}
