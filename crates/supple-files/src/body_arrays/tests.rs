use super::*;
use crate::npy::{encode_f64, encode_texts, encode_u32};
use crate::npz::pack;
use crate::smpl::read_smpl_model;
use crate::{CharacterOptions, read_character};
use glam::DVec3;
use std::path::Path;
use supple::Error;
use supple_bake::Joints;

/// Two bones, the second in front of the first, a shape, and weights by name.
struct Example {
    vertices: Vec<f64>,
    weights: Vec<f64>,
    weight_bones: Vec<u32>,
}

const FACES: [u32; 12] = [0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3];
const JOINTS: [f64; 9] = [0.0, 0.0, 0.0, 0.3, 0.0, 0.0, 0.1, 0.0, 0.0];
/// Bone 1 hangs on bone 2.
const PARENTS: [i64; 3] = [-1, 2, 0];
const SHAPE: [f64; 12] = [0.0, 0.0, 0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
const JOINT_SHAPE: [f64; 9] = [0.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.05, 0.0, 0.0];
const NAMES: [&str; 3] = ["root", "tip", "middle"];

impl Example {
    fn new() -> Self {
        Self {
            vertices: vec![0.0, 0.0, 0.0, 0.4, 0.0, 0.0, 0.0, 0.2, 0.0, 0.0, 0.0, 0.2],
            weights: vec![1.0, 0.0, 0.75, 0.25, 0.5, 0.5, 0.25, 0.75],
            // An unused column may hold anything.
            weight_bones: vec![0, 999, 1, 2, 0, 2, 1, 1],
        }
    }

    fn arrays(&self) -> BodyArrays<'_> {
        BodyArrays {
            vertices: &self.vertices,
            faces: &FACES,
            joints: &JOINTS,
            parents: &PARENTS,
            weights: &self.weights,
            weight_bones: &self.weight_bones,
            shape_directions: &SHAPE,
            joint_directions: &JOINT_SHAPE,
            names: &NAMES,
            ..BodyArrays::default()
        }
    }
}

#[test]
fn bones_come_in_any_order_and_shapes_move_them() {
    let example = Example::new();
    let body = example.arrays().body("example", &[2.0]).unwrap();
    body.skeleton.validate().unwrap();
    assert_eq!(body.skeleton.names, ["root", "middle", "tip"]);
    assert_eq!(body.skeleton.parents, [None, Some(0), Some(1)]);
    let x: Vec<f64> = body.skeleton.joints.iter().map(|j| j.x).collect();
    assert_eq!(x, [0.0, 0.2, 0.7]);
    assert!(body.skin.positions[1].distance(0.6 * DVec3::X) < 1e-15);
    let row = |v: usize| -> Vec<(u32, f64)> {
        let row = body.skinning.row(v).iter();
        row.map(|w| (w.bone, w.weight)).collect()
    };
    assert_eq!(row(0), [(0, 1.0)]);
    assert_eq!(row(1), [(1, 0.25), (2, 0.75)]);
    assert_eq!(row(3), [(2, 1.0)], "named twice, added up");
    // The file's order is kept for hosts.
    assert_eq!(
        body.joints
            .joints()
            .iter()
            .map(|j| &j.name)
            .collect::<Vec<_>>(),
        NAMES
    );
}

#[test]
fn dense_weights_and_a_regressor_say_the_same() {
    let example = Example::new();
    let sparse = example.arrays().model().unwrap();
    let dense = [
        [1.0, 0.0, 0.0],
        [0.0, 0.75, 0.25],
        [0.5, 0.0, 0.5],
        [0.0, 1.0, 0.0],
    ];
    let regressor = [
        [1.0, 0.0, 0.0, 0.0],
        [0.25, 0.75, 0.0, 0.0],
        [0.75, 0.25, 0.0, 0.0],
    ];
    let arrays = BodyArrays {
        weights: dense.as_flattened(),
        weight_bones: &[],
        joints: &[],
        joint_regressor: regressor.as_flattened(),
        joint_directions: &[],
        ..example.arrays()
    };
    let model = arrays.model().unwrap();
    assert_eq!(model.weights, sparse.weights);
    for (a, b) in model.joints(&[0.0]).iter().zip(sparse.joints(&[0.0])) {
        assert!(a.distance(b) < 1e-15, "{a} {b}");
    }
}

/// The same arrays saved by NumPy are a character file.
#[test]
fn an_archive_of_these_names_is_a_character() {
    let example = Example::new();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("example.npz");
    let names = NAMES.map(String::from);
    let parents: Vec<f64> = PARENTS.iter().map(|p| *p as f64).collect();
    let files = [
        ("vertices", encode_f64(&[4, 3], &example.vertices)),
        ("faces", encode_u32(&[4, 3], &FACES)),
        ("joints", encode_f64(&[3, 3], &JOINTS)),
        ("parents", encode_f64(&[3], &parents)),
        ("weights", encode_f64(&[4, 2], &example.weights)),
        ("weight_bones", encode_u32(&[4, 2], &example.weight_bones)),
        ("shape_directions", encode_f64(&[4, 3, 1], &SHAPE)),
        ("joint_directions", encode_f64(&[3, 3, 1], &JOINT_SHAPE)),
        ("names", encode_texts(&names)),
    ];
    std::fs::write(&path, pack(&files).unwrap()).unwrap();
    let read = read_smpl_model(&path).unwrap().model;
    assert_eq!(read, example.arrays().model().unwrap());
    let options = CharacterOptions {
        betas: vec![2.0],
        ..CharacterOptions::default()
    };
    let character = read_character(&path, &options).unwrap();
    let body = example.arrays().body("example", &[2.0]).unwrap();
    assert_eq!(character.body.skeleton, body.skeleton);
    assert_eq!(character.body.joints, body.joints);
    // All that is known of the file is known of the arrays.
    let of_arrays = example
        .arrays()
        .character("example", &[2.0], &Default::default());
    assert_eq!(of_arrays.unwrap(), character);
    let refused = example
        .arrays()
        .character("example", &[f64::NAN], &Default::default());
    assert!(refused.unwrap_err().to_string().starts_with("shape[0]: "));
    // And what is written of it is read.
    crate::write_smpl(&read, &path).unwrap();
    assert_eq!(read_smpl_model(&path).unwrap().model, read);
}

#[test]
fn what_does_not_fit_is_named() {
    let example = Example::new();
    let refused = |arrays: BodyArrays<'_>, field: &str, hint: &str| {
        let error = arrays.body("example", &[]).unwrap_err();
        let text = error.to_string();
        let named = matches!(&error, Error::Invalid { field: f, .. } if f.to_string() == field);
        assert!(named && text.contains(hint), "{text}");
    };
    let right = example.arrays();
    refused(BodyArrays::default(), "vertices", "missing");
    let vertices = &example.vertices[1..];
    refused(BodyArrays { vertices, ..right }, "vertices", "[11]");
    let not_finite = [f64::NAN; 12];
    let vertices = &not_finite;
    refused(BodyArrays { vertices, ..right }, "vertices", "finite");
    let faces = &[0, 1, 4];
    refused(BodyArrays { faces, ..right }, "faces", "vertex 4 of 4");
    let joints = &JOINTS[3..];
    refused(BodyArrays { joints, ..right }, "joints", "[3, 3]");
    let parents = &[-1, 2, 1];
    refused(BodyArrays { parents, ..right }, "parents", "circle");
    let parents = &[0, 0, 0];
    refused(BodyArrays { parents, ..right }, "parents", "only root");
    let weight_bones = &[0, 1, 1, 3, 0, 2, 1, 1];
    let arrays = BodyArrays {
        weight_bones,
        ..right
    };
    refused(arrays, "weight_bones", "bone 3 of 3");
    let weights = &[0.5, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0];
    refused(BodyArrays { weights, ..right }, "weights", "vertex 0");
    let joint_directions = &[];
    let arrays = BodyArrays {
        joint_directions,
        ..right
    };
    refused(arrays, "joint_directions", "J_regressor");
    let names = &["a", "a", "b"];
    refused(BodyArrays { names, ..right }, "names", "3 different");
}

/// A CC0 body given as arrays is the body that its reader gives.
#[test]
fn the_makehuman_body_is_that_of_its_file() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/assets/makehuman-female-game_engine-smpl-layout.npz");
    if !path.exists() {
        return;
    }
    let file = read_smpl_model(&path).unwrap().model;
    let numbers =
        |points: &[DVec3]| -> Vec<f64> { points.iter().flat_map(DVec3::to_array).collect() };
    let (vertices, bones) = (file.template.len(), file.parents.len());
    let mut shapes = Vec::new();
    for v in 0..vertices {
        for axis in 0..3 {
            shapes.extend(file.shape_directions.iter().map(|d| d[v][axis]));
        }
    }
    let mut weights = vec![0.0; vertices * bones];
    for (v, row) in file.weights.iter().enumerate() {
        row.iter()
            .for_each(|w| weights[v * bones + w.bone as usize] = w.weight);
    }
    let Joints::Regressor(rows) = &file.joints else {
        panic!("SMPL's layout has a regressor")
    };
    let mut regressor = vec![0.0; bones * vertices];
    for (j, row) in rows.iter().enumerate() {
        row.iter()
            .for_each(|(v, share)| regressor[j * vertices + *v as usize] = *share);
    }
    let names: Vec<&str> = file.names.iter().map(String::as_str).collect();
    let parents: Vec<i64> = (file.parents.iter())
        .map(|p| p.map_or(-1, i64::from))
        .collect();
    let arrays = BodyArrays {
        vertices: &numbers(&file.template),
        faces: file.triangles.as_flattened(),
        joint_regressor: &regressor,
        parents: &parents,
        weights: &weights,
        shape_directions: &shapes,
        names: &names,
        ..BodyArrays::default()
    };
    assert_eq!(arrays.model().unwrap(), file);
}
