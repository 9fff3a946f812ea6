//! How a file looks: materials, textures and images from a character's file through a bake into the written GLB.

use super::fixture::*;
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use supple::file::{AvatarFile, Parts};
use supple::model::Avatar;
use supple_bake::{Body, Recipe, bake};
use supple_files::{Recording, parse_gltf, write_glb};

/// A picture of one pixel.
pub const PNG: &[u8] = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\0\x01\0\0\0\x01\x08\x06\0\0\0\x1f\x15\xc4\x89\0\0\0\rIDATx\x9cc\xf8\xcf\xc0\xf0\x1f\
    \0\x05\0\x01\xff\x56\xc7\x2f\x0d\0\0\0\0IEND\xaeB`\x82";
const JPEG: &[u8] = b"\xff\xd8\xff\xe0 no more of it than its beginning";

fn primitive(file: &mut Fixture) -> &mut Value {
    &mut file.json["meshes"][0]["primitives"][0]
}

/// Normals of the bar that lean to +x, so that they are not those of its triangles.
fn leaning(bar: &Bar) -> Vec<DVec3> {
    let lean = |p: &DVec3| (DVec3::new(0.0, p.y, p.z).normalize_or_zero() + DVec3::X).normalize();
    bar.positions.iter().map(lean).collect()
}

/// A bar with every attribute that is kept, and two materials of which it shows the second. Where its pictures are, say
/// `images`.
pub fn painted(images: Value) -> Fixture {
    let mut file = bar_file(&BarFile::default());
    let bar = Bar::new(10, 0.05);
    let count = bar.positions.len();
    let sets = [0.25, 0.5].map(|u| {
        let set: Vec<[f32; 2]> = (0..count).map(|v| [u, v as f32 / 100.0]).collect();
        file.floats("VEC2", &set)
    });
    let colours: Vec<u8> = (0..count).flat_map(|v| [255, v as u8, 0, 51]).collect();
    let colours = file.accessor(BYTE, "VEC4", count, &colours);
    file.json["accessors"][colours]["normalized"] = json!(true);
    let normals = leaning(&bar);
    let tangents: Vec<[f32; 4]> = (normals.iter())
        .map(|n| {
            let [x, y, z] = n.any_orthonormal_vector().as_vec3().to_array();
            [x, y, z, -1.0]
        })
        .collect();
    let tangents = file.floats("VEC4", &tangents);
    let normals = file.vectors(&normals);
    let attributes = &mut primitive(&mut file)["attributes"];
    attributes["TEXCOORD_0"] = json!(sets[0]);
    attributes["TEXCOORD_1"] = json!(sets[1]);
    attributes["COLOR_0"] = json!(colours);
    attributes["NORMAL"] = json!(normals);
    attributes["TANGENT"] = json!(tangents);
    primitive(&mut file)["material"] = json!(1);
    file.json["samplers"] = json!([{"wrapS": 33071}, {"magFilter": 9728}]);
    file.json["textures"] = json!([
        {"name": "unused", "source": 2},
        {"source": 1, "sampler": 1, "name": "base"},
        {"source": 0},
    ]);
    file.json["images"] = images;
    let transform =
        json!({"KHR_texture_transform": {"scale": [2, 2]}, "ACME_of_its_own": {"node": 3}});
    file.json["materials"] = json!([
        {"name": "not shown", "emissiveTexture": {"index": 0}},
        {
            "name": "painted",
            "doubleSided": true,
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 1, "extensions": transform}, "roughnessFactor": 0.3},
            "normalTexture": {"index": 2, "texCoord": 1, "scale": 0.5},
            "occlusionTexture": {"index": 9},
            "extensions": {
                "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatTexture": {"index": 1}},
                "ACME_of_its_own": {"node": 3},
            },
            "extras": {"anything": {"someTexture": {"index": 77}}},
        },
    ]);
    file
}

/// Pictures in views: the second texture's is a JPEG.
pub fn embedded() -> Fixture {
    let mut file = painted(json!([]));
    let views = [PNG, JPEG].map(|bytes| file.view(bytes));
    file.json["images"] = json!([
        {"bufferView": views[0], "mimeType": "image/png", "name": "normal map"},
        // What it says it is, it is not.
        {"bufferView": views[1], "mimeType": "image/png"},
        {"bufferView": views[0], "mimeType": "image/png"},
    ]);
    file
}

pub fn baked(body: &Body) -> Avatar {
    bake(body, &Recipe::default(), &mut |_| ()).unwrap().0
}

/// The JSON and the binary chunk of what is written of an avatar whose handles are all displaced.
pub fn written(avatar: &Avatar) -> (Value, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.glb");
    let mut state = avatar.rest_state();
    state.handles.iter_mut().for_each(|h| *h = DVec3::Y * 0.01);
    let recording = Recording {
        times: vec![0.0],
        states: vec![state],
        ..Recording::default()
    };
    write_glb(avatar, &recording, &path).unwrap();
    // Every reference is sound.
    gltf::Gltf::open(&path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let json = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    (json, bytes[28 + length..].to_vec())
}

/// The bytes of a written image.
fn image<'a>(json: &Value, binary: &'a [u8], image: usize) -> &'a [u8] {
    let view = json["images"][image]["bufferView"].as_u64().unwrap() as usize;
    let number = |key: &str| json["bufferViews"][view][key].as_u64().unwrap() as usize;
    &binary[number("byteOffset")..][..number("byteLength")]
}

#[test]
fn what_a_material_needs_is_copied_and_nothing_else() {
    let character = parse_gltf(&embedded().glb(), "bar.glb").unwrap();
    assert_eq!(character.notes, [""; 0]);
    let avatar = baked(&character.body(&[]).unwrap());
    // By way of the baked file.
    let bytes = supple_bake::to_bytes(&avatar, None).unwrap();
    let read = supple_bake::from_bytes(&bytes, "a.supple".as_ref()).unwrap();
    assert!(read.avatar == avatar);
    let (json, binary) = written(&read.avatar);
    let transform = json!({"KHR_texture_transform": {"scale": [2, 2]}});
    let expected = json!([{
        "name": "painted",
        "doubleSided": true,
        "pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions": transform}, "roughnessFactor": 0.3},
        "normalTexture": {"index": 1, "texCoord": 1, "scale": 0.5},
        "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatTexture": {"index": 0}}},
        "extras": {"anything": {"someTexture": {"index": 77}}},
    }]);
    let order = |json: &Value| {
        let normal_first = json["textures"][0] == json!({"source": 0});
        usize::from(normal_first)
    };
    // Keys of an object come in the order of their names: the normal map may come first.
    let first = order(&json);
    let mut expected = expected;
    if first == 1 {
        for (pointer, index) in [
            ("/0/pbrMetallicRoughness/baseColorTexture/index", 1),
            ("/0/normalTexture/index", 0),
            (
                "/0/extensions/KHR_materials_clearcoat/clearcoatTexture/index",
                1,
            ),
        ] {
            *expected.pointer_mut(pointer).unwrap() = json!(index);
        }
    }
    assert_eq!(json["materials"], expected);
    let base = expected.pointer("/0/pbrMetallicRoughness/baseColorTexture/index");
    let base = &json["textures"][base.unwrap().as_u64().unwrap() as usize];
    assert_eq!(base["name"], "base");
    assert_eq!(json["textures"].as_array().unwrap().len(), 2);
    assert_eq!(json["samplers"], json!([{"magFilter": 9728}]));
    assert_eq!(
        json["extensionsUsed"],
        json!(["KHR_materials_clearcoat", "KHR_texture_transform"])
    );
    assert!(json.get("extensionsRequired").is_none());
    for picture in 0..2 {
        let (bytes, kind) = match json["images"][picture].get("name") {
            Some(_) => (PNG, "image/png"),
            None => (JPEG, "image/jpeg"),
        };
        assert_eq!(image(&json, &binary, picture), bytes);
        assert_eq!(json["images"][picture]["mimeType"], kind);
    }
}

#[test]
fn vertices_keep_their_coordinates_colours_normals_and_tangents() {
    let body = parse_gltf(&embedded().glb(), "bar.glb").unwrap();
    let avatar = baked(&body.body(&[]).unwrap());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("step.supple");
    AvatarFile::new(avatar.clone())
        .write(Parts::Step, &path)
        .unwrap();
    let step = supple::file::read_avatar(&path).unwrap();
    assert!(step.appearance.is_empty() && step.render_meshes == avatar.render_meshes);
    let (json, binary) = written(&avatar);
    let attributes = &json["meshes"][0]["primitives"][0]["attributes"];
    let floats = |accessor: &Value, width: usize| -> Vec<Vec<f32>> {
        let accessor = &json["accessors"][accessor.as_u64().unwrap() as usize];
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let first = view["byteOffset"].as_u64().unwrap() as usize;
        let count = accessor["count"].as_u64().unwrap() as usize;
        let bytes = &binary[first..first + 4 * width * count];
        let all: Vec<f32> = bytes
            .as_chunks()
            .0
            .iter()
            .map(|b| f32::from_le_bytes(*b))
            .collect();
        all.chunks(width).map(<[f32]>::to_vec).collect()
    };
    let bar = Bar::new(10, 0.05);
    let [uv_0, uv_1] = ["TEXCOORD_0", "TEXCOORD_1"].map(|name| floats(&attributes[name], 2));
    let colours = floats(&attributes["COLOR_0"], 4);
    let normals = floats(&attributes["NORMAL"], 3);
    let tangents = floats(&attributes["TANGENT"], 4);
    for (v, n) in leaning(&bar).iter().enumerate() {
        let height = v as f32 / 100.0;
        assert_eq!(
            (&uv_0[v], &uv_1[v]),
            (&vec![0.25, height], &vec![0.5, height])
        );
        assert_eq!(colours[v], [1.0, (v as f64 / 255.0) as f32, 0.0, 0.2]);
        // The bind pose is the rest pose here, so the reference shape is the file's own.
        let normal = Vec3::from_slice(&normals[v]).as_dvec3();
        assert!(normal.distance(*n) < 1e-6, "vertex {v}: {normal} {n}");
        let tangent = Vec3::from_slice(&tangents[v]);
        assert!(tangent.is_normalized() && tangents[v][3] == -1.0);
        assert!(tangent.as_dvec3().distance(n.any_orthonormal_vector()) < 1e-6);
    }
}

/// The file's normals turn with the skin below them, wherever they pointed.
#[test]
fn normals_of_a_shape_turn_with_its_skin() {
    let mut file = bar_file(&BarFile::default());
    let bar = Bar::new(10, 0.05);
    let shear: Vec<DVec3> = (bar.positions.iter())
        .map(|p| DVec3::new(0.7 * p.y, 0.0, 0.2 * p.x))
        .collect();
    let shear = file.vectors(&shear);
    primitive(&mut file)["targets"] = json!([{"POSITION": shear}]);
    let own = parse_gltf(&file.glb(), "bar.glb")
        .unwrap()
        .body(&[])
        .unwrap();
    let own = own.skin.vertex_normals();
    let normals = file.vectors(&own);
    primitive(&mut file)["attributes"]["NORMAL"] = json!(normals);
    let character = parse_gltf(&file.glb(), "bar.glb").unwrap();
    let mut turned: f64 = 0.0;
    for amount in [0.0, 1.0] {
        let body = character.body(&[amount]).unwrap();
        let skin = body.skin.vertex_normals();
        let part = &body.render_meshes[0];
        for (normal, &v) in part.normals.iter().zip(&part.vertices) {
            let normal = Vec3::from_array(*normal).as_dvec3();
            assert!(normal.distance(skin[v as usize]) < 1e-6);
            turned = turned.max(normal.angle_between(own[v as usize]));
        }
    }
    assert!(turned > 0.3, "{turned}");
}
