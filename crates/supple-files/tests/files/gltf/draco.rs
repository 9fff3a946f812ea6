//! KHR_draco_mesh_compression: compressed files are, but for rounding, what they were before.

use super::fixture::*;
use super::malformed::refused;
use crate::draco_file::{ATTRIBUTES, bar, draco_bar};
use draco_core::EncoderOptions;
use glam::DVec3;
use serde_json::json;
use supple_files::parse_gltf;

/// Both kinds of connectivity, and each of the ways that edges are walked.
#[test]
fn compressed_bars_are_what_they_were() {
    let expected = parse_gltf(&bar().glb(), "bar.glb").unwrap();
    let expected = expected.body(&[]).unwrap();
    for (method, speed) in [(0, 10), (1, 0), (1, 3), (1, 5), (1, 9)] {
        let mut options = EncoderOptions::new();
        options.set_encoding_method(method);
        options.set_compression_level(10 - speed);
        let file = draco_bar(&options);
        let body = parse_gltf(&file.glb(), "bar.glb")
            .unwrap()
            .body(&[])
            .unwrap();
        assert_eq!(body.skin.triangles.len(), expected.skin.triangles.len());
        assert!(body.skin.is_closed());
        // The order of vertices is the encoder's: each has its neighbour at the same place.
        let mut found: Vec<(DVec3, usize)> = Vec::new();
        for (v, p) in body.skin.positions.iter().enumerate() {
            let near = expected
                .skin
                .positions
                .iter()
                .position(|e| e.distance(*p) < 1e-6);
            let near = near.unwrap_or_else(|| panic!("{method} {speed}: no vertex at {p}"));
            found.push((*p, near));
            let weights = |row: &[supple::model::SkinWeight]| -> Vec<(u32, f64)> {
                row.iter().map(|w| (w.bone, w.weight)).collect()
            };
            let (a, b) = (
                weights(body.skinning.row(v)),
                weights(expected.skinning.row(near)),
            );
            assert_eq!(a.len(), b.len());
            for ((bone, weight), (same, other)) in a.into_iter().zip(b) {
                assert!(bone == same && (weight - other).abs() < 1e-6);
            }
        }
        assert_eq!(found.len(), expected.skin.positions.len());
        let part = &body.render_meshes[0];
        for (normal, v) in part.normals.iter().zip(&part.vertices) {
            let away = body.skin.positions[*v as usize] - DVec3::X * 0.5 * LENGTH;
            let normal = glam::Vec3::from_array(*normal).as_dvec3();
            assert!(normal.distance(away.normalize()) < 1e-5);
        }
        assert_eq!(part.normals.len(), part.vertices.len());
        let coordinates = &body.render_meshes[0].texture_coordinates;
        assert_eq!(coordinates.len(), body.render_meshes[0].vertices.len());
        for (uv, v) in coordinates.iter().zip(&body.render_meshes[0].vertices) {
            let x = body.skin.positions[*v as usize].x as f32;
            assert!((uv[0] - x).abs() < 1e-6 && uv[1] == 0.5, "{uv:?} {x}");
        }
    }
}

#[test]
fn broken_streams_are_refused() {
    let file = draco_bar(&EncoderOptions::new());
    let primitive = |file: &mut Fixture, change: &dyn Fn(&mut serde_json::Value)| {
        let primitive = &mut file.json["meshes"][0]["primitives"][0];
        change(&mut primitive["extensions"]["KHR_draco_mesh_compression"]);
    };
    let position = ATTRIBUTES[0];
    for (key, value, hint) in [
        ("bufferView", json!(99), "bufferViews[99]"),
        ("attributes", json!({position: 77}), "attribute 77"),
        ("attributes", json!({position: 1}), "components"),
    ] {
        let mut file = file.clone();
        primitive(&mut file, &|draco| draco[key] = value.clone());
        refused(&file.glb(), &["meshes[0].primitives[0]", hint]);
    }
    // An attribute beside the stream must have as many vertices as it.
    let mut file = file.clone();
    let morph = file.vectors(&[DVec3::X; 3]);
    file.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": morph}]);
    refused(&file.glb(), &["3 elements for"]);
}
