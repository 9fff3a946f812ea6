//! The parametric model on it: weights, joints, shape and pose directions, its file.

use super::shape::mirrored;
use super::{betas, body, joint, other_side, skin, surface_of};
use crate::tests::surface::{dense_weights, edges, winding_number};
use supple::glam::{DMat3, DVec3};
use supple::internal::math::rotation_exp;
use supple_bake::{Joints, ParametricModel};
use supple_files::{read_smpl, write_smpl};

#[test]
fn weights_are_a_smooth_partition_without_seams() {
    let model = &body().model;
    let dense = dense_weights::<24>(model, 5);
    for (i, j) in edges(&model.triangles) {
        let (a, b) = (&dense[i as usize], &dense[j as usize]);
        let length = model.template[i as usize].distance(model.template[j as usize]);
        for k in 0..24 {
            // No seam: a weight takes at least 11 mm from 0 to 1, on the trunk far more.
            let slope = (a[k] - b[k]).abs() / length;
            assert!(slope < 1.0 / 11e-3, "bone {k}: {slope} 1/m on edge {i}–{j}");
            assert!((a[k] - b[k]).abs() < 0.6, "bone {k} on edge {i}–{j}");
        }
    }
    for (weights, p) in dense.iter().zip(&model.template) {
        for k in 0..24 {
            let side = if model.names[k].starts_with("left") {
                1.0
            } else {
                -1.0
            };
            let is_sided = model.names[k].contains('_');
            assert!(
                !is_sided || weights[k] == 0.0 || side * p.x > -0.08,
                "bone {k} at {p}"
            );
        }
    }
    for k in 0..24 {
        // The short bones of the spine share all their places, but carry most of some.
        let carries = |w: &[f64; 24]| w[k] > 0.4 && w.iter().all(|other| *other <= w[k]);
        assert!(dense.iter().any(carries), "bone {k} carries nothing");
    }
}

#[test]
fn the_tree_and_the_joints_are_smpls() {
    let model = &body().model;
    let parents: Vec<i64> = (model.parents.iter())
        .map(|p| p.map_or(-1, i64::from))
        .collect();
    assert_eq!(
        parents,
        [
            -1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 20, 21
        ]
    );
    let joints = model.joints(&[]);
    let skin = skin();
    let Joints::Regressor(rows) = &model.joints else {
        panic!("the sample has a regressor")
    };
    for (j, row) in rows.iter().enumerate() {
        assert!(
            (winding_number(joints[j], &skin) - 1.0).abs() < 1e-6,
            "joint {j}"
        );
        assert!((row.iter().map(|r| r.1).sum::<f64>() - 1.0).abs() < 1e-6);
        // From the ring of vertices around it alone, and hanging on none of them.
        let reach = row
            .iter()
            .map(|r| skin.positions[r.0 as usize].distance(joints[j]));
        assert!(
            row.len() < 700 && reach.fold(0.0, f64::max) < 0.3,
            "joint {j}"
        );
        assert!(row.iter().all(|r| r.1.abs() < 0.5), "joint {j}");
        let other = joints[joint(&other_side(&model.names[j]))];
        assert!(mirrored(joints[j]).distance(other) < 1e-9, "joint {j}");
    }
}

#[test]
fn shape_directions_make_clearly_different_people() {
    let model = &body().model;
    assert_eq!(model.shape_directions.len(), 10);
    let areas = skin().vertex_areas();
    let product = |a: &[DVec3], b: &[DVec3]| -> f64 {
        let terms = a.iter().zip(b).zip(&areas);
        terms.map(|((u, v), area)| area * u.dot(*v)).sum()
    };
    for (k, a) in model.shape_directions.iter().enumerate() {
        let largest = a.iter().map(|v| v.length()).fold(0.0, f64::max);
        assert!(largest > 8e-3, "direction {k} moves {largest} m at most");
        for b in &model.shape_directions[..k] {
            let cosine = product(a, b) / (product(a, a) * product(b, b)).sqrt();
            assert!(cosine.abs() < 1e-9, "{cosine}");
        }
    }
    // What they are called is what they do.
    let of = |k: usize, value: f64| model.shaped(&betas(k, value));
    let height = |p: &[DVec3]| p.iter().map(|p| p.y).fold(f64::MIN, f64::max);
    assert!((0.13..0.16).contains(&(height(&of(0, 2.0)) - height(&model.template))));
    let volume = |p: Vec<DVec3>| surface_of(p).volume();
    assert!(volume(of(1, 2.0)) > 1.3 * skin().volume());
    assert!(volume(of(1, -2.0)) < 0.75 * skin().volume());
    let front = |p: &[DVec3], low: f64, high: f64| {
        let band = p
            .iter()
            .filter(|p| (low..high).contains(&p.y) && p.x.abs() < 0.13);
        band.map(|p| p.z).fold(f64::MIN, f64::max)
    };
    let grown = |k: usize, low: f64, high: f64| {
        front(&of(k, 2.0), low, high) - front(&of(k, -2.0), low, high)
    };
    let (breast, belly) = ((1.22, 1.30), (0.97, 1.10));
    assert!(grown(4, breast.0, breast.1) > 0.04 && grown(4, belly.0, belly.1) < 0.02);
    assert!(grown(5, belly.0, belly.1) > 0.05 && grown(5, breast.0, breast.1) < 0.025);
    // The floor stays under every one of them.
    for (k, value) in (0..10).flat_map(|k| [(k, -2.0), (k, 2.0)]) {
        let sole = of(k, value).iter().map(|p| p.y).fold(f64::MAX, f64::min);
        assert!(
            sole.abs() < 0.012,
            "direction {k} at {value}: the sole is at {sole} m"
        );
    }
}

/// Local rotations: the named joints about x, y and z, degrees, and their mirror images.
fn posed(turns: &[(&str, [f64; 3])]) -> Vec<DMat3> {
    let mut pose = vec![DMat3::IDENTITY; 24];
    for &(name, degrees) in turns {
        let [x, y, z] = degrees.map(f64::to_radians);
        pose[joint(&other_side(name))] = rotation_exp(DVec3::new(x, -y, -z));
        pose[joint(name)] = rotation_exp(DVec3::new(x, y, z));
    }
    pose
}

#[test]
fn pose_directions_give_back_volume_that_linear_blending_loses() {
    let model = &body().model;
    assert_eq!(model.pose_directions.len(), 207);
    let mut plain = model.clone();
    plain.pose_directions.clear();
    let volume = |model: &ParametricModel, pose: &[DMat3]| {
        surface_of(model.evaluate(&[], pose, DVec3::ZERO)).volume()
    };
    let rest = skin().volume();
    // Sitting, squatting, elbows and knees bent, fists raised: no pose of the fit, which bends one joint.
    let sitting = [
        ("left_hip", [-85.0, 0.0, 0.0]),
        ("left_knee", [85.0, 0.0, 0.0]),
    ];
    let squatting = [
        ("left_hip", [-95.0, 0.0, 12.0]),
        ("left_knee", [115.0, 0.0, 0.0]),
        ("left_ankle", [-20.0, 0.0, 0.0]),
        ("spine1", [20.0, 0.0, 0.0]),
    ];
    let bent = [
        ("left_elbow", [0.0, -100.0, 0.0]),
        ("left_knee", [90.0, 0.0, 0.0]),
    ];
    let poses: [&[_]; 3] = [&sitting, &squatting, &bent];
    for turns in poses {
        let pose = posed(turns);
        let (without, with) = (rest - volume(&plain, &pose), rest - volume(model, &pose));
        println!(
            "{turns:?}: {:.2} l lost without, {:.2} l with",
            1e3 * without,
            1e3 * with
        );
        assert!(
            without > 0.0 && with.abs() < 0.5 * without,
            "{turns:?}: {without} {with}"
        );
    }
    let identity = model.evaluate(&[], &[DMat3::IDENTITY; 24], DVec3::ZERO);
    let off = identity
        .iter()
        .zip(&model.template)
        .map(|(a, b)| a.distance(*b));
    assert!(off.fold(0.0, f64::max) < 1e-12);
    // A bent left knee changes nothing of what no bone around it moves.
    let mut pose = vec![DMat3::IDENTITY; 24];
    pose[joint("left_knee")] = rotation_exp(DVec3::new(1.5, 0.0, 0.0));
    let frames = model.skeleton(&[]).forward_kinematics(&pose, DVec3::ZERO);
    let unposed = model.unposed(&[], &frames);
    let around = ["left_hip", "left_knee"].map(joint);
    for (v, row) in model.weights.iter().enumerate() {
        let touched = row.iter().any(|w| around.contains(&(w.bone as usize)));
        assert!(
            touched || unposed[v].distance(model.template[v]) < 1e-12,
            "vertex {v}"
        );
    }
}

#[test]
fn its_archive_reads_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("body.npz");
    write_smpl(&body().model, &path).unwrap();
    assert!(read_smpl(&path).unwrap() == body().model);
    // The whole crate must stay below 10 MB packed; this file is made when it is asked for.
    assert!(std::fs::metadata(&path).unwrap().len() < 8 << 20);
}

#[test]
fn the_same_body_comes_out_every_time() {
    let again = crate::body().expect("the built-in body is made");
    assert!(again == *body());
}
