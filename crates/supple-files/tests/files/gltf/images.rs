//! Images in a file, in its text and beside it, missing ones, and appearances that nobody checked.

use super::fixture::*;
use super::materials::{PNG, baked, painted, written};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;
use supple::model::{Appearance, Image};
use supple_files::{Recording, parse_gltf, read_gltf, write_glb};

#[test]
fn pictures_beside_the_file_are_embedded_and_what_is_missing_is_said() {
    const DATA: &str = "data:image/png;base64,iVBORw0KGgo=";
    let file = painted(json!([
        {"uri": "pictures/a%20b.png"},
        {"uri": DATA},
        {"uri": "../../secret.png"},
    ]));
    let folder = tempfile::tempdir().unwrap();
    let put = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    std::fs::create_dir(folder.path().join("pictures")).unwrap();
    put("bar.bin", &file.binary);
    put("bar.gltf", &file.text("bar.bin"));
    put("pictures/a b.png", PNG);
    let path = folder.path().join("bar.gltf");
    let character = read_gltf(&path).unwrap();
    assert_eq!(character.notes, [""; 0]);
    let appearance = character.body(&[]).unwrap().appearance;
    let bytes: Vec<&[u8]> = appearance.images.iter().map(|i| &*i.bytes).collect();
    // No drawn part shows the third.
    assert_eq!(bytes, [PNG, b"\x89PNG\r\n\x1a\n", b""]);

    // Gone, no picture, outside: the material is kept without it.
    std::fs::remove_file(folder.path().join("pictures/a b.png")).unwrap();
    for (image, hint) in [
        (json!({"uri": "pictures/a%20b.png"}), "a b.png"),
        (json!({"uri": "bar.bin"}), "no picture"),
        (json!({"uri": "../bar.png"}), "folder"),
        (json!({"uri": "/etc/passwd"}), "folder"),
        (json!({"bufferView": 999}), "bufferViews[999]"),
        (json!({}), "neither"),
    ] {
        let mut file = file.clone();
        file.json["images"][0] = image;
        put("bar.gltf", &file.text("bar.bin"));
        let character = read_gltf(&path).unwrap();
        let [note] = &character.notes[..] else {
            panic!("{:?}", character.notes)
        };
        assert!(note.contains("images[0]") && note.contains(hint), "{note}");
        let (json, _) = written(&baked(&character.body(&[]).unwrap()));
        assert_eq!(json["images"].as_array().unwrap().len(), 1);
        let material = &json["materials"][0];
        assert_eq!(material["name"], "painted");
        assert!(material.get("normalTexture").is_none());
        assert!(
            material["pbrMetallicRoughness"]
                .get("baseColorTexture")
                .is_some()
        );
    }
}

/// A baked file may say anything: what is written of it names only what is there.
#[test]
fn an_unsound_appearance_is_made_sound() {
    let body = parse_gltf(&bar_file(&BarFile::default()).glb(), "bar.glb").unwrap();
    let mut avatar = baked(&body.body(&[]).unwrap());
    avatar.render_meshes[0].material_index = Some(0);
    let picture = Image {
        name: String::new(),
        mime_type: "image/png".into(),
        bytes: PNG.to_vec(),
    };
    let appearance = |gltf: Value| {
        Arc::new(Appearance {
            gltf: gltf.to_string(),
            images: vec![picture.clone(), Image::default()],
        })
    };
    let textures = json!([
        {"source": 0, "sampler": 5}, {"source": 1}, {"source": 9}, 7,
        {"source": 0, "extensions": {"EXT_texture_webp": {"source": 0}}},
    ]);
    for (info, kept) in [
        (json!({"index": 0}), true),
        (json!({"index": 0, "texCoord": 3}), true),
        (json!({"index": 4}), true),
        (json!({"index": 0, "texCoord": 4_000_000_000u32}), false),
        (json!({"index": 1}), false),
        (json!({"index": 2}), false),
        (json!({"index": 3}), false),
        (json!({"index": -1}), false),
        (json!({}), false),
    ] {
        let material = json!({"emissiveTexture": info, "extensions": {"KHR_materials_unlit": 7}});
        let gltf = json!({"materials": [material], "textures": textures, "samplers": 3});
        avatar.appearance = appearance(gltf);
        let (json, _) = written(&avatar);
        let material = &json["materials"][0];
        assert_eq!(material.get("emissiveTexture").is_some(), kept, "{info}");
        assert!(material.get("extensions").is_none());
        assert!(json.get("extensionsUsed").is_none());
        if kept {
            assert_eq!(json["textures"], json!([{"source": 0}]));
            // Coordinates that the part lacks are there, all the same.
            let sets = json["meshes"][0]["primitives"][0]["attributes"]
                .as_object()
                .unwrap();
            let sets = sets.keys().filter(|k| k.starts_with("TEXCOORD")).count();
            assert_eq!(sets as u64, 1 + info["texCoord"].as_u64().unwrap_or(0));
        }
    }
    for gltf in [
        json!({"materials": []}),
        json!({"materials": [3]}),
        json!({}),
    ] {
        avatar.appearance = appearance(gltf);
        let (json, _) = written(&avatar);
        // Its own colour.
        assert!(json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"].is_array());
    }
    avatar.appearance = appearance(json!([]));
    let recording = Recording {
        times: vec![0.0],
        states: vec![avatar.rest_state()],
        ..Recording::default()
    };
    let error = write_glb(&avatar, &recording, Path::new("never.glb")).unwrap_err();
    assert!(error.to_string().contains("appearance.gltf"), "{error}");
}
