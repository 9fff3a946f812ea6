use super::published::Published;
use super::*;
use crate::pickle::writer::Python::{Three, Two};
use glam::{DMat3, DVec3};
use supple::internal::math::{Random, rotation_exp};

/// Largest distance that the model keeps from the published evaluation, m.
const TOLERANCE: f64 = 1e-12;

fn parse(bytes: &[u8]) -> Result<SmplModel> {
    parse_smpl(bytes, Path::new("model"))
}

fn refused(bytes: &[u8], key: &str, hint: &str) {
    let error = parse(bytes).expect_err(hint).to_string();
    assert!(error.contains(key) && error.contains(hint), "{error}");
}

/// The three forms in which a model comes.
fn files(published: &Published) -> [Vec<u8>; 3] {
    [
        published.npz(),
        published.pickle(Two),
        published.pickle(Three),
    ]
}

fn random_pose(bones: usize, random: &mut Random) -> Vec<[f64; 3]> {
    (0..bones).map(|_| random.vector(1.5).to_array()).collect()
}

fn distance(a: &[DVec3], b: &[[f64; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let apart = a
        .iter()
        .zip(b)
        .map(|(a, b)| (*a - DVec3::from_array(*b)).length());
    apart.fold(0.0, f64::max)
}

fn rotations(pose: &[[f64; 3]]) -> Vec<DMat3> {
    pose.iter()
        .map(|v| rotation_exp(DVec3::from_array(*v)))
        .collect()
}

#[test]
fn every_model_agrees_with_the_published_evaluation() {
    use SmplKind::{Mano, Other, Smpl, SmplH, SmplX};
    for (bones, columns, kind) in [
        (24, 10, Smpl),
        (52, 16, SmplH),
        (55, 20, SmplX),
        (55, 400, SmplX),
        (16, 10, Mano),
        (7, 3, Other),
    ] {
        let mut random = Random::new(bones as u64);
        let published = Published::random(bones, 9, columns, &mut random);
        let pose = random_pose(bones, &mut random);
        let betas: Vec<f64> = (0..3).map(|_| random.uniform(-3.0, 3.0)).collect();
        let expression = [0.7, -1.1];
        let shift = DVec3::new(0.3, -2.0, 1.0);
        // SMPL-X's expression stands at column 300, in small files at column 10.
        let first = if columns == 400 { 300 } else { 10 };
        let mut by_column: Vec<(usize, f64)> = betas.iter().copied().enumerate().collect();
        if kind == SmplX {
            by_column.extend([(first, expression[0]), (first + 1, expression[1])]);
        }
        let expected = published.evaluate(&by_column, &pose, shift.to_array());
        for file in files(&published) {
            let read = parse(&file).unwrap();
            assert_eq!(read.kind, kind);
            let coefficients = match kind {
                SmplX => read.coefficients(&betas, &expression),
                _ => betas.clone(),
            };
            let found = read.model.evaluate(&coefficients, &rotations(&pose), shift);
            let apart = distance(&found, &expected);
            assert!(apart < TOLERANCE, "{kind:?}: {apart:e} m apart");
        }
    }
}

#[test]
fn bones_are_sorted_and_known_by_their_ids() {
    let mut random = Random::new(3);
    let mut published = Published::random(6, 8, 2, &mut random);
    // 0 ← 4 ← 1 ← 5, 4 ← 2, 0 ← 3, under other ids.
    published.ids = vec![10, 11, 12, 13, 14, 15];
    published.parents = vec![u32::MAX, 14, 14, 10, 10, 11];
    let pose = random_pose(6, &mut random);
    let expected = published.evaluate(&[(1, 0.5)], &pose, [0.0; 3]);
    for file in files(&published) {
        let model = parse(&file).unwrap().model;
        assert_eq!(
            model.names,
            ["bone_0", "bone_3", "bone_4", "bone_1", "bone_2", "bone_5"]
        );
        assert_eq!(
            model.parents[1..],
            [Some(0), Some(0), Some(2), Some(2), Some(3)]
        );
        let sorted: Vec<_> = [0, 3, 4, 1, 2, 5].iter().map(|&j| pose[j]).collect();
        let found = model.evaluate(&[0.0, 0.5], &rotations(&sorted), DVec3::ZERO);
        assert!(distance(&found, &expected) < TOLERANCE);
    }
}

#[test]
fn pose_directions_may_lie_the_other_way_round() {
    let published = Published::random(4, 5, 1, &mut Random::new(8));
    let (features, places) = (27, 15);
    let turned: Vec<f64> = (0..features)
        .flat_map(|k| (0..places).map(move |at| (k, at)))
        .map(|(k, at)| published.posedirs[at * features + k])
        .collect();
    let flat = crate::npy::encode_f64(&[features, places], &turned);
    let file = with_member(&published.npz(), "posedirs", &flat);
    assert_eq!(parse(&file).unwrap(), parse(&published.npz()).unwrap());
    let wrong = crate::npy::encode_f64(&[places, features], &turned);
    let file = with_member(&published.npz(), "posedirs", &wrong);
    refused(
        &file,
        "posedirs",
        "shape [15, 27], expected numbers of shape [27, 15]",
    );
}

/// The archive with another member under `key`.
fn with_member(archive: &[u8], key: &str, bytes: &[u8]) -> Vec<u8> {
    use std::io::{Cursor, Write};
    let name = format!("{key}.npy");
    let mut from = zip::ZipArchive::new(Cursor::new(archive)).unwrap();
    let mut to = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for i in 0..from.len() {
        let member = from.by_index_raw(i).unwrap();
        if member.name().unwrap() != name {
            to.raw_copy_file(member).unwrap();
        }
    }
    to.start_file(name, zip::write::SimpleFileOptions::default())
        .unwrap();
    to.write_all(bytes).unwrap();
    to.finish().unwrap().into_inner()
}

#[test]
fn hands_are_posed_by_their_components() {
    for (bones, keys, first) in [
        (16, &[("hands_mean", "hands_components", 1)][..], 1),
        (
            52,
            &[
                ("hands_meanl", "hands_componentsl", 22),
                ("hands_meanr", "hands_componentsr", 37),
            ],
            22,
        ),
        (
            55,
            &[
                ("hands_meanl", "hands_componentsl", 25),
                ("hands_meanr", "hands_componentsr", 40),
            ],
            25,
        ),
    ] {
        let mut random = Random::new(5);
        let mut published = Published::random(bones, 5, 2, &mut random);
        for (mean, components, _) in keys {
            let mut numbers = |count| (0..count).map(|_| random.uniform(-1.0, 1.0)).collect();
            published.hands.push((mean, vec![45], numbers(45)));
            published
                .hands
                .push((components, vec![45, 45], numbers(45 * 45)));
        }
        for file in files(&published) {
            let read = parse(&file).unwrap();
            assert_eq!(read.hands.len(), keys.len());
            for (h, hand) in read.hands.iter().enumerate() {
                assert_eq!(hand.bones[0], keys[h].2);
                assert_eq!(hand.bones.len(), 15);
                let (mean, components) = (&published.hands[2 * h].2, &published.hands[2 * h + 1].2);
                let flat = hand.rotations(&[0.5, -2.0], true).unwrap();
                let relaxed = hand.rotations(&[0.5, -2.0], false).unwrap();
                for at in 0..45 {
                    let expected = 0.5 * components[at] - 2.0 * components[45 + at];
                    assert_eq!(flat[at / 3][at % 3], expected);
                    assert_eq!(relaxed[at / 3][at % 3], expected + mean[at]);
                }
                let error = hand.rotations(&[0.0; 46], true).unwrap_err().to_string();
                assert!(error.contains("46 coefficients for 45"), "{error}");
            }
            assert_eq!(read.hands[0].bones[0], first);
        }
    }
}

#[test]
fn published_names_stand_in_the_published_order() {
    let of = |bones| names::of(names::kind(bones), bones);
    for bones in [16, 24, 52, 55] {
        let mut unique = of(bones);
        assert_eq!(unique.len(), bones);
        unique.sort();
        unique.dedup();
        assert_eq!(unique.len(), bones);
    }
    let at = |bones, places: [usize; 3]| places.map(|j: usize| of(bones)[j].clone());
    assert_eq!(at(16, [0, 1, 15]), ["wrist", "index1", "thumb3"]);
    assert_eq!(at(24, [0, 15, 23]), ["pelvis", "head", "right_hand"]);
    assert_eq!(
        at(52, [21, 22, 37]),
        ["right_wrist", "left_index1", "right_index1"]
    );
    assert_eq!(at(55, [22, 25, 54]), ["jaw", "left_index1", "right_thumb3"]);
}

#[test]
fn broken_models_are_refused_by_key() {
    let broken = |change: &dyn Fn(&mut Published), key: &str, hint: &str| {
        let mut published = Published::random(4, 5, 2, &mut Random::new(1));
        change(&mut published);
        files(&published)
            .iter()
            .for_each(|file| refused(file, key, hint));
    };
    broken(
        &|p| p.parents = vec![u32::MAX, 2, 3, 1],
        "kintree_table",
        "circle",
    );
    broken(
        &|p| p.parents[2] = 9,
        "kintree_table",
        "bone 2 has parent 9",
    );
    broken(&|p| p.parents[3] = u32::MAX, "kintree_table", "only root");
    broken(&|p| p.ids[3] = 1, "kintree_table", "share the id 1");
    broken(&|p| p.weights[0] = -1.0, "weights", "vertex 0");
    broken(&|p| p.regressor[3] += 0.1, "J_regressor", "joint 0");
    broken(
        &|p| p.template[4] = f64::NAN,
        "v_template",
        "element 4 is not finite",
    );
    let published = Published::random(4, 5, 2, &mut Random::new(1));
    let none = Three.program(&Three.dict(&[("f", Three.u32s(&[1, 3], &[0, 1, 2]))]));
    refused(&none, "v_template", "is missing; there are f");
    let text = [("v_template", Three.text("lost"))];
    refused(
        &Three.program(&Three.dict(&text)),
        "v_template",
        "text, expected",
    );
    let other = [("v_template", Three.dict(&[]))];
    refused(
        &Three.program(&Three.dict(&other)),
        "v_template",
        "a dictionary, not an array",
    );
    let narrow = crate::npy::encode_f64(&[5, 3], &[0.2; 15]);
    let narrow = with_member(&published.npz(), "weights", &narrow);
    refused(
        &narrow,
        "weights",
        "shape [5, 3], expected numbers of shape [5, 4]",
    );
}
