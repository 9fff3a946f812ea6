//! SMPL archives and OBJ files: what is written is read, and nothing that is broken gets through.

use proptest::prelude::*;
use std::path::{Path, PathBuf};
use supple::Error;
use supple::glam::{DMat3, DVec3};
use supple::internal::math::Rows;
use supple::model::{SkinWeight, Surface};
use supple_bake::{Joints, ParametricModel};
use supple_files::{read_closed_obj, read_obj, read_smpl, write_obj, write_smpl};

/// A tetrahedron with two bones, one shape and nine pose directions.
fn model() -> ParametricModel {
    let template = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z * 0.1];
    let directions = |count: usize| -> Vec<Vec<DVec3>> {
        let value = |k: usize, v: usize| DVec3::new(k as f64, v as f64 / 3.0, 0.1 * (k * v) as f64);
        (0..count)
            .map(|k| (0..4).map(|v| value(k, v)).collect())
            .collect()
    };
    let weight = |bone, weight| SkinWeight { bone, weight };
    ParametricModel {
        triangles: vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
        shape_directions: directions(1),
        pose_directions: directions(9),
        weights: Rows::from_iter([
            vec![weight(0, 1.0)],
            vec![weight(0, 0.25), weight(1, 0.75)],
            vec![weight(1, 1.0)],
            vec![weight(0, 0.5), weight(1, 0.5)],
        ]),
        joints: Joints::Regressor(Rows::from_iter([vec![(0, 1.0)], vec![(1, 0.5), (2, 0.5)]])),
        parents: vec![None, Some(0)],
        names: vec!["root".into(), "tip".into()],
        template,
    }
}

fn folder() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("file");
    (folder, path)
}

fn format_error<T: std::fmt::Debug>(result: Result<T, Error>, field: &str, hint: &str) {
    let error = result.unwrap_err();
    let text = error.to_string();
    assert!(
        matches!(&error, Error::Format { field: f, .. } if f == field),
        "{text}"
    );
    assert!(text.contains(hint), "{text}");
}

#[test]
fn smpl_round_trip_is_exact_and_deterministic() {
    let (_folder, path) = folder();
    let model = model();
    write_smpl(&model, &path).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    assert_eq!(read_smpl(&path).unwrap(), model);
    write_smpl(&model, &path).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), bytes);
}

#[test]
fn smpl_errors_name_the_key() {
    let (_folder, path) = folder();
    let wrong = |change: &dyn Fn(&mut ParametricModel), key: &str, hint: &str| {
        let mut m = model();
        change(&mut m);
        write_smpl(&m, &path).unwrap();
        format_error(read_smpl(&path), key, hint);
    };
    wrong(
        &|m| m.triangles[1][2] = 4,
        "f",
        "triangle 1 names vertex 4 of 4",
    );
    wrong(
        &|m| m.parents[1] = Some(1),
        "kintree_table",
        "bone 1 has parent 1",
    );
    wrong(
        &|m| m.template[2].y = f64::NAN,
        "v_template",
        "element 7 is not finite",
    );
    wrong(
        &|m| m.names[1] = "root".into(),
        "joint_names",
        "2 different texts",
    );
    wrong(
        &|m| {
            m.pose_directions.pop();
        },
        "posedirs",
        "shape [4, 3, 8], expected numbers of shape [4, 3, 9]",
    );
    wrong(
        &|m| {
            m.weights = Rows::from_iter(vec![
                [SkinWeight {
                    bone: 0,
                    weight: 0.5
                }];
                4
            ])
        },
        "weights",
        "vertex 0: weights must be positive and sum to 1, not 0.5",
    );
    std::fs::write(&path, b"PK but no archive").unwrap();
    format_error(read_smpl(&path), "archive", "no .npz");
    assert!(matches!(read_smpl("nowhere.npz"), Err(Error::Io { .. })));
}

#[test]
fn obj_round_trip_is_exact() {
    let (_folder, path) = folder();
    let m = model();
    let low = Surface {
        positions: m.template,
        triangles: m.triangles,
    };
    let mut high = low.clone();
    high.positions
        .iter_mut()
        .for_each(|p| *p = *p * (1.0 / 3.0) + DVec3::Z);
    write_obj([("low", &low), ("high bone", &high)], &path).unwrap();
    let expected = vec![("low".to_string(), low), ("high bone".to_string(), high)];
    let read = read_closed_obj(&path).unwrap();
    let corners = |objects: &[(String, Surface)]| -> Vec<_> {
        let of = |s: &Surface| {
            (0..s.triangles.len())
                .map(|t| s.corners(t))
                .collect::<Vec<_>>()
        };
        objects
            .iter()
            .map(|(name, s)| (name.clone(), of(s)))
            .collect()
    };
    assert_eq!(corners(&read), corners(&expected));
    assert_eq!(read[1].1.positions.len(), 4);
}

#[test]
fn broken_obj_files_are_refused() {
    let (_folder, path) = folder();
    let refuse = |text: &str, field: &str, hint: &str| {
        std::fs::write(&path, text).unwrap();
        format_error(read_closed_obj(&path), field, hint);
    };
    refuse("", "faces", "there are none");
    refuse(
        "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "a",
        "not closed",
    );
    refuse("o a\nv 0 0 0\nf 1 2 3\n", "line 3", "vertex `2` of 1");
    refuse(
        "o a\nv 0 nan 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "line 2",
        "finite",
    );
    refuse("v 0 0 0\nv 1 0 0\nf 1 2\n", "line 3", "three vertices");
    refuse("v 0 0 0\nf 1 -2 1\n", "line 2", "`-2`");
    let inside_out =
        "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 2 4 3\nf 1 3 4\n";
    refuse(inside_out, "a", "inside out");
}

#[test]
fn obj_polygons_groups_and_relative_indices_are_read() {
    let (_folder, path) = folder();
    let text = "mtllib none.mtl\nv 9 9 9\nv 0 0 0 1 1 1\nv 1 0 0\nv 1 1 0\nv 0 1 0\ng first part\nusemtl a\n\
        f -4//1 -3/7 \\\n -2 -1\r\nusemtl b\ng second\nf 5 4 3\n";
    std::fs::write(&path, text).unwrap();
    let read = read_obj(&path).unwrap();
    assert_eq!(read[0].0, "first part");
    assert_eq!(read[0].1.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(read[0].1.positions[1], DVec3::X);
    assert_eq!(
        read[1].1.positions,
        [DVec3::Y, DVec3::new(1.0, 1.0, 0.0), DVec3::X]
    );
    // With an object, groups are parts of it.
    std::fs::write(&path, format!("o whole\n{text}")).unwrap();
    let whole = read_obj(&path).unwrap();
    assert_eq!(
        (whole.len(), &*whole[0].0, whole[0].1.triangles.len()),
        (1, "whole", 3)
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Whatever happens to the bytes, the answer is a model or an error.
    #[test]
    fn corrupt_archives_never_panic(flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4), cut in 0usize..64) {
        let (_folder, path) = folder();
        write_smpl(&model(), &path).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        for (at, value) in flips {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        bytes.truncate(bytes.len() - cut / 8);
        std::fs::write(&path, bytes).unwrap();
        let _ = read_smpl(&path);
    }

    #[test]
    fn corrupt_obj_never_panics(text in "[ovf 0-9/.\\-\n]{0,80}") {
        let (_folder, path) = folder();
        std::fs::write(&path, text).unwrap();
        let _ = read_obj(&path);
    }
}

/// A real model, where it is at hand.
#[test]
fn a_real_body_is_read() {
    let path = Path::new(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../../shared/assets/makehuman-female-game_engine-smpl-layout.npz"
    ));
    if !path.exists() {
        println!(
            "skipped: {} is not there; the other tests cover the layout",
            path.display()
        );
        return;
    }
    let body = read_smpl(path).unwrap();
    assert_eq!(body.template.len(), 13_380);
    assert_eq!(body.parents.len(), 53);
    assert_eq!(body.shape_directions.len(), 10);
    assert!(body.skeleton(&[]).validate().is_ok());
    let upright = body.evaluate(&[], &[DMat3::IDENTITY; 53], DVec3::ZERO);
    let worst = upright
        .iter()
        .zip(&body.template)
        .map(|(a, b)| (*a - *b).length());
    assert!(
        worst.fold(0.0, f64::max) < 1e-9,
        "the bind pose is the template"
    );
}

/// Pickles that NumPy, SciPy and classes of chumpy's names wrote (tests/data/README.md).
#[test]
fn pickles_that_python_wrote_are_read() {
    let number = |n: usize| n as f64;
    let vectors = |f: &dyn Fn(f64, f64) -> f64| -> Vec<DVec3> {
        let vector = |v| DVec3::from_array([0, 1, 2].map(|a| f(number(v), number(a))));
        (0..4).map(vector).collect()
    };
    let expected = ParametricModel {
        template: vectors(&|v, a| v + a / 4.0 - v * a / 8.0),
        shape_directions: (0..2)
            .map(|k| vectors(&|v, a| v - a + number(k) / 2.0))
            .collect(),
        pose_directions: (0..9)
            .map(|k| vectors(&|v, a| v + 2.0 * a - number(k) / 4.0))
            .collect(),
        joints: Joints::Regressor(Rows::from_iter([
            vec![(0, 1.0)],
            vec![(1, 0.5), (2, 0.25), (3, 0.25)],
        ])),
        ..model()
    };
    for protocol in [0, 2, 4, 5] {
        let path = format!("tests/data/model_protocol{protocol}.pkl");
        assert_eq!(read_smpl(&path).unwrap(), expected, "{path}");
    }
}
