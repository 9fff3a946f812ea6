//! AMASS's motions and those of its kind.

use std::io::Write;
use std::path::{Path, PathBuf};
use supple::Error;
use supple::glam::{DQuat, DVec3};
use supple::internal::math::{Random, rotation_exp};
use supple::model::UpAxis;
use supple_files::{AmassOptions, read_amass, read_amass_with, read_betas};

type Arrays<'a> = &'a [(&'a str, &'a [usize], &'a [f64])];

/// Bytes of a `.npy` file of f64.
fn npy(shape: &[usize], values: &[f64]) -> Vec<u8> {
    let sizes: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let mut header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({sizes}), }}");
    header += &" ".repeat((64 - (11 + header.len()) % 64) % 64);
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

fn npz(folder: &Path, arrays: Arrays<'_>) -> PathBuf {
    let path = folder.join("motion.npz");
    let mut zip = zip::ZipWriter::new(std::fs::File::create(&path).unwrap());
    for (name, shape, values) in arrays {
        let options = zip::write::SimpleFileOptions::default();
        zip.start_file(format!("{name}.npy"), options).unwrap();
        zip.write_all(&npy(shape, values)).unwrap();
    }
    zip.finish().unwrap();
    path
}

#[test]
fn amass_is_read_in_every_width_and_spelling() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random::new(3);
    for (width, bones, rate) in [
        (72, 24, "mocap_framerate"),
        (66, 22, "mocap_frame_rate"),
        (156, 52, "mocap_framerate"),
        (165, 55, "mocap_frame_rate"),
        (48, 16, "mocap_framerate"),
    ] {
        let poses: Vec<f64> = (0..2 * width).map(|_| random.uniform(-1.0, 1.0)).collect();
        let trans = [0.0, 0.5, 1.0, 0.1, 0.6, 1.1];
        let path = npz(
            folder.path(),
            &[
                ("poses", &[2, width], &poses),
                ("trans", &[2, 3], &trans),
                (rate, &[], &[120.0]),
            ],
        );
        let clip = read_amass(&path).unwrap();
        assert_eq!((clip.bones.len(), clip.frames.len()), (bones, 2));
        assert_eq!((clip.rest_up, clip.world_up), (UpAxis::Y, UpAxis::Z));
        assert!((clip.frame_time - 1.0 / 120.0).abs() < 1e-15);
        assert_eq!(clip.frames[1].translations, [DVec3::new(0.1, 0.6, 1.1)]);
        for j in 0..bones {
            let v = DVec3::from_slice(&poses[width + 3 * j..]);
            let expected = DQuat::from_mat3(&rotation_exp(v));
            assert!(clip.frames[1].rotations[j].angle_between(expected) < 1e-7);
        }
        for (name, parent) in [
            ("left_index1", "left_wrist"),
            ("right_thumb3", "right_thumb2"),
            ("jaw", "head"),
            ("right_foot", "right_ankle"),
            ("pinky1", "wrist"),
        ] {
            if let Some(j) = clip.find(name) {
                assert_eq!(clip.bones[clip.parents[j].unwrap() as usize], parent);
            }
        }
    }
}

#[test]
fn a_broken_amass_names_its_key() {
    let folder = tempfile::tempdir().unwrap();
    let wrong = |arrays: Arrays<'_>, field: &str, hint: &str| {
        let error = read_amass(npz(folder.path(), arrays)).unwrap_err();
        let text = error.to_string();
        assert!(
            matches!(&error, Error::Format { field: f, .. } if f == field),
            "{text}"
        );
        assert!(text.contains(hint), "{text}");
    };
    let (poses, trans) = ([0.0; 72], [0.0; 3]);
    let rate: (&str, &[usize], &[f64]) = ("mocap_framerate", &[], &[60.0]);
    wrong(&[("trans", &[1, 3], &trans), rate], "poses", "missing");
    wrong(&[("poses", &[1, 72], &poses), rate], "trans", "missing");
    wrong(
        &[("poses", &[1, 72], &poses), ("trans", &[1, 3], &trans)],
        "mocap_framerate",
        "missing",
    );
    wrong(
        &[
            ("poses", &[1, 72], &poses),
            ("trans", &[1, 3], &trans),
            ("mocap_framerate", &[], &[0.0]),
        ],
        "mocap_framerate",
        "missing",
    );
    wrong(
        &[
            ("poses", &[2, 36], &poses),
            ("trans", &[1, 3], &trans),
            rate,
        ],
        "poses",
        "36 numbers",
    );
    wrong(
        &[
            ("poses", &[1, 72], &poses),
            ("trans", &[3, 1], &trans),
            rate,
        ],
        "trans",
        "shape",
    );
    wrong(
        &[("poses", &[0, 72], &[]), ("trans", &[0, 3], &[]), rate],
        "motion.frames",
        "none",
    );
    let mut bad = poses;
    bad[5] = f64::NAN;
    wrong(
        &[("poses", &[1, 72], &bad), ("trans", &[1, 3], &trans), rate],
        "poses",
        "element 5",
    );
}

/// `poses` in parts, with and without hands and face.
#[test]
fn parts_are_joined_as_poses_has_them() {
    let folder = tempfile::tempdir().unwrap();
    let mut random = Random::new(6);
    let mut part =
        |width: usize| -> Vec<f64> { (0..2 * width).map(|_| random.uniform(-1.0, 1.0)).collect() };
    let (root, body, hands, jaw, eyes) = (part(3), part(63), part(90), part(3), part(6));
    let all: Arrays<'_> = &[
        ("root_orient", &[2, 3], &root),
        ("pose_body", &[2, 63], &body),
        ("trans", &[2, 3], &[0.0; 6]),
        ("fps", &[1], &[30.0]),
        ("pose_hand", &[2, 90], &hands),
        ("pose_jaw", &[2, 3], &jaw),
        ("pose_eye", &[2, 6], &eyes),
    ];
    let read = |arrays: Arrays<'_>| read_amass(npz(folder.path(), arrays)).unwrap();
    assert_eq!(read(&all[..4]).bones.len(), 22);
    assert_eq!(read(&all[..5]).bones.len(), 52);
    let clip = read(all);
    assert_eq!(clip.bones.len(), 55);
    assert_eq!(clip.frame_time, 1.0 / 30.0);
    let turned = |bone: &str, part: &[f64]| {
        let wanted = DQuat::from_scaled_axis(DVec3::from_slice(part));
        let found = clip.frames[1].rotations[clip.find(bone).unwrap()];
        assert!(found.angle_between(wanted) < 1e-7, "{bone}");
    };
    turned("pelvis", &root[3..]);
    turned("left_hip", &body[63..]);
    turned("jaw", &jaw[3..]);
    turned("right_eye", &eyes[9..]);
    turned("left_index1", &hands[90..]);
    turned("right_thumb3", &hands[177..]);
    // A hand in MANO's components is no list of rotations.
    let mut components = all[..5].to_vec();
    components[4] = ("pose_hand", &[2, 24], &hands[..48]);
    let clip = read(&components);
    assert_eq!(clip.bones.len(), 22);
    assert!(
        clip.notes.concat().contains("pose_hand"),
        "{:?}",
        clip.notes
    );
    // Whole poses go before their parts.
    let whole = [all, &[("poses", &[2, 66], &[0.0; 132])]].concat();
    assert_eq!(read(&whole).frames[1].rotations[1], DQuat::IDENTITY);
}

#[test]
fn a_rate_is_the_file_s_or_the_reader_s_or_aist_s() {
    let folder = tempfile::tempdir().unwrap();
    let (poses, trans, way) = ([0.0; 72], [0.0; 3], [90.0, 180.0, 9.0]);
    let none: Arrays<'_> = &[("poses", &[1, 72], &poses), ("trans", &[1, 3], &trans)];
    let error = read_amass(npz(folder.path(), none))
        .unwrap_err()
        .to_string();
    for cure in ["motion.npz", "mocap_framerate", "rate = 60", "--rate"] {
        assert!(error.contains(cure), "{error}");
    }
    let at = |rate: f64| AmassOptions { rate: Some(rate) };
    let clip = read_amass_with(npz(folder.path(), none), &at(25.0)).unwrap();
    assert_eq!((clip.frame_time, clip.world_up), (1.0 / 25.0, UpAxis::Z));
    for wrong in [0.0, f64::NAN, -1.0] {
        let error = read_amass_with(npz(folder.path(), none), &at(wrong)).unwrap_err();
        assert!(error.to_string().contains("rate"), "{error}");
    }
    let aist: Arrays<'_> = &[
        ("smpl_poses", &[1, 72], &poses),
        ("smpl_trans", &[1, 3], &way),
        ("smpl_scaling", &[1], &[90.0]),
    ];
    let clip = read_amass(npz(folder.path(), aist)).unwrap();
    assert_eq!(clip.frames[0].translations, [DVec3::new(1.0, 2.0, 0.1)]);
    assert_eq!((clip.frame_time, clip.world_up), (1.0 / 60.0, UpAxis::Y));
    assert!(clip.notes.concat().contains("60 frames a second"));
    let clip = read_amass_with(npz(folder.path(), aist), &at(30.0)).unwrap();
    assert_eq!((clip.frame_time, clip.notes.len()), (1.0 / 30.0, 0));
}

#[test]
fn a_person_s_shape_is_told_and_given() {
    let folder = tempfile::tempdir().unwrap();
    let file = |betas: &[f64], shape: &[usize]| {
        npz(
            folder.path(),
            &[
                ("poses", &[1, 72], &[0.0; 72]),
                ("trans", &[1, 3], &[0.0; 3]),
                ("fps", &[], &[60.0]),
                ("betas", shape, betas),
            ],
        )
    };
    let betas = [1.0, -2.0, 0.5, 0.25];
    let path = file(&betas, &[4]);
    let said = read_amass(&path).unwrap().notes.concat();
    assert!(
        said.contains("4 betas") && said.contains("--shape-of"),
        "{said}"
    );
    assert_eq!(read_betas(&path).unwrap(), betas);
    assert_eq!(read_betas(file(&betas, &[2, 2])).unwrap(), betas[..2]);
    let refused = |path: PathBuf| {
        let error = read_betas(&path).unwrap_err();
        assert!(
            matches!(&error, Error::Format { field, .. } if field == "betas"),
            "{error}"
        );
    };
    refused(file(&[], &[0]));
    refused(file(&[0.0; 401], &[401]));
    refused(npz(folder.path(), &[("fps", &[], &[60.0])]));
}
