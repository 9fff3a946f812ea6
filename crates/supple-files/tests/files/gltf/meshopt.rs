//! EXT_meshopt_compression and KHR_meshopt_compression: compressed files are what they were before.

use super::fixture::*;
use super::malformed::{refused, rich};
use crate::meshopt_encoder::{Channel, attributes, indices, triangles};
use serde_json::json;
use supple_bake::Body;
use supple_files::gltf::Character;
use supple_files::{parse_gltf, parse_gltf_motions};

/// How a view of a fixture is compressed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mode {
    Attributes,
    AttributesV1,
    Triangles,
    Indices,
}

pub const KHR: &str = "KHR_meshopt_compression";
pub const EXT: &str = "EXT_meshopt_compression";

/// `file` with the view of `accessor` compressed into one that is not there otherwise.
fn compress(file: &mut Fixture, accessor: usize, mode: Mode, extension: &str) {
    let found = file.json["accessors"][accessor].clone();
    let view = found["bufferView"].as_u64().unwrap() as usize;
    let number =
        |file: &Fixture, key: &str| file.json["bufferViews"][view][key].as_u64().unwrap() as usize;
    let (offset, length) = (number(file, "byteOffset"), number(file, "byteLength"));
    let count = found["count"].as_u64().unwrap() as usize;
    let bytes = file.binary[offset..offset + length].to_vec();
    let stride = length / count;
    let of_shorts = || -> Vec<u32> {
        bytes
            .as_chunks()
            .0
            .iter()
            .map(|b| u16::from_le_bytes(*b).into())
            .collect()
    };
    let kinds = [
        Channel::Xor(0),
        Channel::Shorts,
        Channel::Bytes,
        Channel::Xor(9),
    ];
    let kinds: Vec<Channel> = kinds.into_iter().cycle().take(stride / 4).collect();
    let (name, coded) = match mode {
        Mode::Attributes => ("ATTRIBUTES", attributes(&bytes, stride, None)),
        Mode::AttributesV1 => ("ATTRIBUTES", attributes(&bytes, stride, Some(&kinds))),
        Mode::Triangles => ("TRIANGLES", triangles(&of_shorts())),
        Mode::Indices => ("INDICES", indices(&of_shorts())),
    };
    let new = file.view(&coded);
    let place = file.json["bufferViews"][new].clone();
    file.json["bufferViews"][view] = json!({
        "buffer": 1, "byteOffset": 0, "byteLength": length, "extensions": {extension: {
            "buffer": 0, "byteOffset": place["byteOffset"], "byteLength": place["byteLength"],
            "byteStride": stride, "count": count, "mode": name,
        }},
    });
    file.binary[offset..offset + length].fill(0xee);
    file.json["extensionsRequired"] = json!([extension]);
}

/// As a GLB with a second buffer that has no bytes.
fn glb(file: &Fixture) -> Vec<u8> {
    let mut file = file.clone();
    let length = file.binary.len();
    file.json["buffers"] = json!([{"byteLength": length}, {"byteLength": 1 << 20}]);
    file.glb_with_buffers()
}

/// The body with each triangle turned to begin with its lowest vertex: meshopt turns them.
fn sorted(character: &Character) -> Body {
    let mut body = character.body(&[]).unwrap();
    let turn = |t: &mut [u32; 3]| {
        let lowest = (0..3).min_by_key(|k| t[*k]).unwrap();
        t.rotate_left(lowest);
    };
    body.skin.triangles.iter_mut().for_each(turn);
    (body.render_meshes.iter_mut()).for_each(|part| part.triangles.iter_mut().for_each(turn));
    body
}

fn attribute(file: &Fixture, name: &str) -> usize {
    let attributes = &file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes[name].as_u64().unwrap() as usize
}

/// The rich file with all that is compressible compressed.
pub fn compressed(extension: &str, vertices: Mode, triangles: Mode) -> Vec<u8> {
    let mut file = rich();
    let corners = file.json["meshes"][0]["primitives"][0]["indices"]
        .as_u64()
        .unwrap() as usize;
    let sampler = file.json["animations"][0]["samplers"][0].clone();
    let keys = ["input", "output"].map(|k| sampler[k].as_u64().unwrap() as usize);
    for name in ["POSITION", "JOINTS_0", "WEIGHTS_0", "TEXCOORD_0"] {
        let accessor = attribute(&file, name);
        compress(&mut file, accessor, vertices, extension);
    }
    for key in keys {
        compress(&mut file, key, vertices, extension);
    }
    compress(&mut file, corners, triangles, extension);
    glb(&file)
}

/// The rich file with positions in a view that this stream is to become, and such a stream.
pub fn with_positions(stream: &[u8]) -> Vec<u8> {
    let mut file = rich();
    let position = attribute(&file, "POSITION");
    compress(&mut file, position, Mode::AttributesV1, KHR);
    let view = file.json["accessors"][position]["bufferView"]
        .as_u64()
        .unwrap() as usize;
    let new = file.view(stream);
    let place = file.json["bufferViews"][new].clone();
    let how = &mut file.json["bufferViews"][view]["extensions"][KHR];
    how["byteOffset"] = place["byteOffset"].clone();
    how["byteLength"] = place["byteLength"].clone();
    glb(&file)
}

/// A stream for [`with_positions`].
pub fn stream_of_positions(kinds: &[Channel]) -> Vec<u8> {
    let positions = Bar::new(10, 0.05).positions;
    let bytes = positions.iter().flat_map(|p| p.as_vec3().to_array());
    let bytes: Vec<u8> = bytes.flat_map(f32::to_le_bytes).collect();
    attributes(&bytes, 12, Some(kinds))
}

#[test]
fn compressed_files_are_what_they_were() {
    let plain = rich();
    let expected = parse_gltf(&plain.glb(), "bar.glb").unwrap();
    let motions = parse_gltf_motions(&plain.glb(), "bar.glb").unwrap();
    for extension in [EXT, KHR] {
        for vertices in [Mode::Attributes, Mode::AttributesV1] {
            for triangles in [Mode::Triangles, Mode::Indices] {
                let glb = compressed(extension, vertices, triangles);
                let found = parse_gltf(&glb, "bar.glb").unwrap();
                assert!(
                    sorted(&found) == sorted(&expected),
                    "{extension} {vertices:?} {triangles:?}"
                );
                assert_eq!(parse_gltf_motions(&glb, "bar.glb").unwrap(), motions);
            }
        }
    }
}

/// More elements than a block has, and than a byte counts; triangles in an order that meets few edges again.
#[test]
fn long_streams() {
    let mut file = bar_file(&BarFile {
        rings: 70,
        ..BarFile::default()
    });
    let corners = file.json["meshes"][0]["primitives"][0]["indices"]
        .as_u64()
        .unwrap() as usize;
    let expected = parse_gltf(&file.glb(), "bar.glb").unwrap();
    for name in ["POSITION", "JOINTS_0", "WEIGHTS_0"] {
        let accessor = attribute(&file, name);
        compress(&mut file, accessor, Mode::AttributesV1, KHR);
    }
    compress(&mut file, corners, Mode::Triangles, KHR);
    let found = parse_gltf(&glb(&file), "bar.glb").unwrap();
    assert!(sorted(&found) == sorted(&expected));
}

#[test]
fn broken_streams_are_refused() {
    let plain = rich();
    let position = attribute(&plain, "POSITION");
    let mut file = plain.clone();
    compress(&mut file, position, Mode::Attributes, EXT);
    let view = plain.json["accessors"][position]["bufferView"]
        .as_u64()
        .unwrap() as usize;
    let changed = |key: &str, value: serde_json::Value| {
        let mut file = file.clone();
        file.json["bufferViews"][view]["extensions"][EXT][key] = value;
        glb(&file)
    };
    for (key, value, hint) in [
        ("buffer", json!(7), "leaves its buffer"),
        ("byteLength", json!(u64::MAX), "leaves its buffer"),
        ("byteLength", json!(30), "too early"),
        ("byteOffset", json!(0), "do not begin"),
        ("byteStride", json!(10), "10 bytes"),
        ("byteStride", json!(0), "0 bytes"),
        ("count", json!(u64::MAX), "more bytes"),
        ("count", json!(3), "too many"),
        ("mode", json!("COLOURS"), "COLOURS"),
        ("mode", json!("TRIANGLES"), "broken"),
        ("filter", json!("QUATERNION"), "QUATERNION"),
        ("filter", json!("MAGIC"), "MAGIC"),
    ] {
        refused(&changed(key, value), &["bufferViews", hint]);
    }
    // A view that nobody reads may be anything.
    let mut unread = file.clone();
    let broken = unread.json["bufferViews"][view].clone();
    unread.json["bufferViews"][view] = json!({"buffer": 0, "byteLength": 0});
    let view = unread.push("bufferViews", broken);
    unread.json["bufferViews"][view]["extensions"][EXT]["mode"] = json!("COLOURS");
    let positions: Vec<_> = Bar::new(10, 0.05).positions;
    let positions = unread.vectors(&positions);
    unread.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(positions);
    parse_gltf(&glb(&unread), "bar.glb").unwrap();
}

/// Many views of the same few bytes cannot ask for any amount.
#[test]
fn what_a_small_file_becomes_is_bounded() {
    let mut file = rich();
    let zeros = attributes(&vec![0; 4 << 20], 256, Some(&[Channel::Bytes; 64]));
    let small = file.view(&zeros);
    let place = file.json["bufferViews"][small].clone();
    let mut last = 0;
    for _ in 0..20 {
        last = file.push("bufferViews", json!({
            "buffer": 1, "byteLength": 4 << 20, "extensions": {KHR: {
                "buffer": 0, "byteOffset": place["byteOffset"], "byteLength": place["byteLength"],
                "byteStride": 256, "count": 4 << 12, "mode": "ATTRIBUTES",
            }},
        }));
    }
    let count = Bar::new(10, 0.05).positions.len();
    let accessor =
        json!({"bufferView": last, "componentType": FLOAT, "count": count, "type": "VEC3"});
    let accessor = file.push("accessors", accessor);
    file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(accessor);
    refused(&glb(&file), &["more bytes, all together"]);
}

/// KHR_mesh_quantization: whole numbers, normalised or not, and a placement that undoes it.
#[test]
fn quantised_positions_are_placed_by_the_bind() {
    let plain = bar_file(&BarFile::default());
    let whole = parse_gltf(&plain.glb(), "bar.glb")
        .unwrap()
        .body(&[])
        .unwrap();
    for (component, normalised, steps) in [
        (5122, true, 32767.0),
        (5122, false, 1.0),
        (5120, true, 127.0),
    ] {
        // Units of a step of the whole number are 0.1 mm, or 6 mm of the coarse ones.
        let unit = if component == 5120 { 6e-3 } else { 1e-4 };
        let mut file = plain.clone();
        let bar = Bar::new(10, 0.05);
        let numbers: Vec<i16> = (bar.positions.iter())
            .flat_map(|p| [p.x, p.y, p.z, 0.0])
            .map(|c| (c / unit).round() as i16)
            .collect();
        let bytes: Vec<u8> = match component {
            5120 => numbers.iter().map(|v| *v as i8 as u8).collect(),
            _ => numbers.iter().flat_map(|v| v.to_le_bytes()).collect(),
        };
        let count = bar.positions.len();
        let accessor = file.accessor(component, "VEC3", count, &bytes);
        file.json["accessors"][accessor]["normalized"] = json!(normalised);
        let view = file.json["accessors"][accessor]["bufferView"]
            .as_u64()
            .unwrap() as usize;
        file.json["bufferViews"][view]["byteStride"] = json!(bytes.len() / count);
        file.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(accessor);
        file.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        // The bind matrices undo the units.
        let scale = glam::DMat4::from_scale(glam::DVec3::splat(unit * steps));
        let bind = joint_worlds(glam::DAffine3::IDENTITY, &[glam::DQuat::IDENTITY; BONES]);
        let inverse = bind.map(|b| glam::DMat4::from(b.inverse()) * scale);
        let inverse = file.matrices(&inverse);
        file.json["skins"][0]["inverseBindMatrices"] = json!(inverse);
        let body = parse_gltf(&file.glb(), "bar.glb")
            .unwrap()
            .body(&[])
            .unwrap();
        for (a, b) in body.skin.positions.iter().zip(&whole.skin.positions) {
            // Half a step of each axis, and f32.
            assert!(a.distance(*b) < 0.87 * unit + 1e-6, "{a} {b}");
        }
    }
}
