//! Buffers, accessors, kinds of primitives, seams, morph targets.

use super::evaluation::{Evaluation, check_rest, largest_distance, posed};
use super::fixture::*;
use glam::DVec3;
use serde_json::json;
use supple_files::{parse_gltf, read_gltf};

const RINGS: usize = 10;

fn plain() -> Fixture {
    bar_file(&BarFile::default())
}

/// The first primitive of a fixture.
fn primitive(file: &mut Fixture) -> &mut serde_json::Value {
    &mut file.json["meshes"][0]["primitives"][0]
}

#[test]
fn buffers_in_the_text_beside_it_and_in_the_binary_are_one() {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let file = plain();
    let expected = parse_gltf(&file.glb(), "bar.glb").unwrap();
    let mut text = String::from("data:application/octet-stream;base64,");
    for three in file.binary.chunks(3) {
        let byte = |k: usize| u32::from(three.get(k).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            let digit = char::from(DIGITS[(bits >> (18 - 6 * k) & 63) as usize]);
            text.push(if k > three.len() { '=' } else { digit });
        }
    }
    let embedded = parse_gltf(&file.text(&text), "bar.gltf").unwrap();
    assert!(embedded == expected);
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("a b")).unwrap();
    std::fs::write(folder.path().join("a b/c.bin"), &file.binary).unwrap();
    std::fs::write(folder.path().join("bar.gltf"), file.text("a%20b/c.bin")).unwrap();
    assert!(read_gltf(folder.path().join("bar.gltf")).unwrap() == expected);
}

#[test]
fn sparse_accessors_and_strides() {
    let mut file = plain();
    let bar = Bar::new(RINGS, 0.05);
    // Positions interleaved with something else, two of them replaced.
    let count = bar.positions.len();
    let bytes: Vec<u8> = (bar.positions.iter())
        .flat_map(|p| [p.x as f32, p.y as f32, p.z as f32, 7.0])
        .flat_map(f32::to_le_bytes)
        .collect();
    let view = file.view(&bytes);
    file.json["bufferViews"][view]["byteStride"] = json!(16);
    let places: Vec<u8> = [3u16, 40].iter().flat_map(|v| v.to_le_bytes()).collect();
    let places = file.view(&places);
    let replaced = [DVec3::new(0.0, 0.03, 0.01), DVec3::new(0.31, 0.04, -0.01)];
    let values: Vec<u8> = (replaced.iter())
        .flat_map(|v| v.as_vec3().to_array())
        .flat_map(f32::to_le_bytes)
        .collect();
    let values = file.view(&values);
    let accessor = file.push(
        "accessors",
        json!({
            "bufferView": view, "componentType": FLOAT, "count": count, "type": "VEC3",
            "sparse": {
                "count": 2,
                "indices": {"bufferView": places, "componentType": SHORT},
                "values": {"bufferView": values},
            },
        }),
    );
    primitive(&mut file)["attributes"]["POSITION"] = json!(accessor);
    let body = check_rest(&file.glb());
    for (v, p) in [3, 40].into_iter().zip(replaced) {
        assert!(body.skin.positions[v].distance(p) < 1e-7);
    }
}

#[test]
fn quantised_positions_mean_what_floats_mean() {
    let bar = Bar::new(RINGS, 0.05);
    // Whole steps of 1/65535 in a box of 1 m around the bar; as floats and as normalised shorts.
    let steps = |p: &DVec3| ((*p + DVec3::splat(0.2)) * 65535.0).round().to_array();
    let short: Vec<u16> = bar
        .positions
        .iter()
        .flat_map(steps)
        .map(|v| v as u16)
        .collect();
    let floats: Vec<DVec3> = (short.chunks(3))
        .map(|p| DVec3::new(p[0].into(), p[1].into(), p[2].into()) / 65535.0)
        .collect();
    let [mut quantised, mut plain] = [plain(), plain()];
    let accessor = quantised.shorts("VEC3", bar.positions.len(), &short);
    quantised.json["accessors"][accessor]["normalized"] = json!(true);
    quantised.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    primitive(&mut quantised)["attributes"]["POSITION"] = json!(accessor);
    let accessor = plain.vectors(&floats);
    primitive(&mut plain)["attributes"]["POSITION"] = json!(accessor);
    let [quantised, plain] = [quantised, plain].map(|f| {
        parse_gltf(&f.glb(), "bar.glb")
            .unwrap()
            .body(&[])
            .unwrap()
            .skin
    });
    assert_eq!(quantised.triangles, plain.triangles);
    let pairs = quantised.positions.iter().zip(&plain.positions);
    assert!(pairs.into_iter().all(|(a, b)| a.distance(*b) < 1e-7));
}

#[test]
fn lists_without_indices_strips_and_fans() {
    let expected = check_rest(&plain().glb());
    let bar = Bar::new(RINGS, 0.05);
    let (joints, weights) = bar.influences();
    // Every corner of every triangle a vertex of its own.
    let mut list = plain();
    let corners: Vec<usize> = bar
        .triangles
        .iter()
        .flatten()
        .map(|v| *v as usize)
        .collect();
    let positions: Vec<DVec3> = corners.iter().map(|v| bar.positions[*v]).collect();
    let joints: Vec<[u8; 4]> = corners.iter().map(|v| joints[*v]).collect();
    let weights: Vec<[f32; 4]> = corners.iter().map(|v| weights[*v]).collect();
    let attributes = json!({
        "POSITION": list.vectors(&positions),
        "JOINTS_0": list.accessor(BYTE, "VEC4", joints.len(), joints.as_flattened()),
        "WEIGHTS_0": list.floats("VEC4", &weights),
    });
    *primitive(&mut list) = json!({"attributes": attributes});
    let body = check_rest(&list.glb());
    assert!(body.skin.is_closed());
    assert_eq!(body.skin.positions.len(), expected.skin.positions.len());
    assert_eq!(body.render_meshes[0].vertices.len(), corners.len());

    // Two fans for the ends, a strip for each pair of rings.
    let mut parts = plain();
    let last = bar.positions.len() as u16 - 1;
    let ring = |r: u16, k: u16| 1 + 8 * r + k % 8;
    let mut pieces: Vec<(u32, Vec<u16>)> = vec![
        (
            6,
            std::iter::once(0)
                .chain((0..9).rev().map(|k| ring(0, k)))
                .collect(),
        ),
        (
            6,
            std::iter::once(last)
                .chain((0..9).map(|k| ring(RINGS as u16 - 1, k)))
                .collect(),
        ),
    ];
    for r in 0..RINGS as u16 - 1 {
        pieces.push((
            5,
            (0..9).flat_map(|k| [ring(r + 1, k), ring(r, k)]).collect(),
        ));
    }
    let attributes = primitive(&mut parts)["attributes"].clone();
    let pieces: Vec<_> = (pieces.iter())
        .map(|(mode, indices)| {
            let indices = parts.shorts("SCALAR", indices.len(), indices);
            json!({"attributes": attributes, "indices": indices, "mode": mode})
        })
        .collect();
    let lines = json!({"attributes": attributes, "mode": 1});
    parts.json["meshes"][0]["primitives"] = pieces.into_iter().chain([lines]).collect();
    let character = parse_gltf(&parts.glb(), "bar.glb").unwrap();
    assert_eq!(character.notes.len(), 1, "{:?}", character.notes);
    let body = character.body(&[]).unwrap();
    assert!(body.skin.is_closed());
    let ratio = body.skin.volume() / expected.skin.volume();
    assert!((ratio - 1.0).abs() < 1e-6, "{ratio}");
    assert_eq!(body.skin.positions.len(), expected.skin.positions.len());
}

#[test]
fn seams_are_welded_and_kept() {
    let mut file = plain();
    let bar = Bar::new(RINGS, 0.05);
    // The bar is cut open along k = 0: those vertices come twice, with other texture coordinates.
    let (joints, weights) = bar.influences();
    let first = bar.positions.len() as u16;
    let seam: Vec<u16> = (0..RINGS as u16).map(|r| 1 + 8 * r).collect();
    let all: Vec<usize> = (0..first)
        .chain(seam.iter().copied())
        .map(usize::from)
        .collect();
    let beyond = |v: u16| bar.positions[v as usize].z < -1e-6;
    let triangles: Vec<u16> = (bar.triangles.iter())
        .flat_map(|t| {
            let far = t.iter().any(|v| beyond(*v));
            t.map(|v| match seam.iter().position(|s| *s == v) {
                Some(k) if far => first + k as u16,
                _ => v,
            })
        })
        .collect();
    let coordinates: Vec<[f32; 2]> = (0..all.len()).map(|v| [v as f32, 0.5]).collect();
    let tangent = |v| [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, -1.0]][v % 2];
    let tangents: Vec<[f32; 4]> = (0..all.len()).map(tangent).collect();
    let positions: Vec<DVec3> = all.iter().map(|v| bar.positions[*v]).collect();
    let joints: Vec<[u8; 4]> = all.iter().map(|v| joints[*v]).collect();
    let weights: Vec<[f32; 4]> = all.iter().map(|v| weights[*v]).collect();
    let attributes = json!({
        "POSITION": file.vectors(&positions),
        "TEXCOORD_0": file.floats("VEC2", &coordinates),
        "TANGENT": file.floats("VEC4", &tangents),
        "JOINTS_0": file.accessor(BYTE, "VEC4", joints.len(), joints.as_flattened()),
        "WEIGHTS_0": file.floats("VEC4", &weights),
    });
    let indices = file.shorts("SCALAR", triangles.len(), &triangles);
    file.push("materials", json!({"name": "copper"}));
    let material = file.push("materials", json!({"name": "steel"}));
    *primitive(&mut file) =
        json!({"attributes": attributes, "indices": indices, "material": material});
    let body = check_rest(&file.glb());
    assert!(body.skin.is_closed());
    assert_eq!(body.skin.positions.len(), bar.positions.len());
    let [part] = &body.render_meshes[..] else {
        panic!()
    };
    assert_eq!((&*part.name, &*part.material), ("bar", "steel"));
    assert_eq!(part.material_index, Some(1));
    assert_eq!(part.texture_coordinates, coordinates);
    assert_eq!(part.tangents.len(), tangents.len());
    // The file's bind matrices are in f32.
    let pairs = part
        .tangents
        .as_flattened()
        .iter()
        .zip(tangents.as_flattened());
    let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(worst < 1e-6, "{worst}");
    assert_eq!(part.triangles.as_flattened().len(), triangles.len());

    // With weights of their own the vertices of the cut stay apart where they are drawn only.
    let mut torn = weights.clone();
    for w in &mut torn[first as usize..] {
        *w = [w[0] * 0.95 + 0.05, w[1] * 0.95, 0.0, 0.0];
    }
    let torn = file.floats("VEC4", &torn);
    primitive(&mut file)["attributes"]["WEIGHTS_0"] = json!(torn);
    let body = check_rest(&file.glb());
    assert!(body.skin.is_closed());
    assert_eq!(body.skin.positions.len(), bar.positions.len());
    let copies: usize = body
        .attachments
        .iter()
        .map(|a| a.surface.positions.len())
        .sum();
    assert!(copies > 0 && copies <= RINGS, "{copies}");
    // In a pose, each is where the file has it.
    let mut bent = file.clone();
    for j in 1..=BONES {
        bent.json["nodes"][j]["rotation"] = json!([0.0, 0.6, 0.0, 0.8]);
    }
    let pose = parse_gltf(&bent.glb(), "bent.glb").unwrap();
    let of_file = Evaluation::new(&bent.glb());
    let found = posed(&pose.body(&[]).unwrap(), &pose.rest);
    let expected = of_file.skinned(&of_file.rest());
    let distance = largest_distance(&pose.body(&[]).unwrap(), &found, &expected);
    assert!(distance < 1e-6, "{distance}");
}

#[test]
fn morph_targets_are_shapes() {
    let mut file = plain();
    let bar = Bar::new(RINGS, 0.05);
    let fat: Vec<DVec3> = bar
        .positions
        .iter()
        .map(|p| DVec3::new(0.0, p.y, p.z))
        .collect();
    let targets = [
        file.vectors(&fat),
        file.vectors(&vec![DVec3::Z * 0.5; fat.len()]),
    ];
    let targets = targets.map(|t| json!({"POSITION": t}));
    primitive(&mut file)["targets"] = json!(targets);
    file.json["meshes"][0]["weights"] = json!([0.0, 0.1]);
    file.json["meshes"][0]["extras"] = json!({"targetNames": ["fat", "up"]});
    let character = parse_gltf(&file.glb(), "bar.glb").unwrap();
    let names: Vec<&str> = character.shapes().iter().map(|s| &*s.name).collect();
    assert_eq!(names, ["fat", "up"]);
    let default = character.body(&[]).unwrap();
    let body = character.body(&[0.5, 0.0]).unwrap();
    assert_eq!(body.skeleton, default.skeleton);
    for (v, p) in bar.positions.iter().enumerate() {
        assert!(default.skin.positions[v].distance(*p + DVec3::Z * 0.05) < 1e-6);
        let expected = DVec3::new(p.x, 1.5 * p.y, 1.5 * p.z);
        assert!(body.skin.positions[v].distance(expected) < 1e-6);
    }
    for wrong in [&[0.0, 0.0, 0.0][..], &[f64::NAN]] {
        let error = character.body(wrong).unwrap_err().to_string();
        assert!(error.starts_with("shape:"), "{error}");
    }
}

#[test]
fn painted_attributes_are_maps_of_the_skin() {
    let mut file = plain();
    let bar = Bar::new(RINGS, 0.05);
    let values: Vec<[f32; 1]> = bar.along.iter().map(|s| [*s as f32]).collect();
    let accessor = file.floats("SCALAR", &values);
    primitive(&mut file)["attributes"]["_SOFT"] = json!(accessor);
    let colours: Vec<[f32; 3]> = bar.along.iter().map(|s| [0.5, *s as f32, 1.0]).collect();
    let colours = file.floats("VEC3", &colours);
    primitive(&mut file)["attributes"]["COLOR_0"] = json!(colours);
    let body = check_rest(&file.glb());
    let expected: Vec<f64> = values.iter().map(|[s]| f64::from(*s)).collect();
    assert_eq!(body.painted["soft"], expected);
    assert_eq!(body.painted["color_0.g"], expected);
    assert!(body.painted["color_0.r"].iter().all(|r| *r == 0.5));
}
