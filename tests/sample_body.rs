//! The generated body is a closed, symmetric, well-formed, well-behaved human body.

#[path = "support/surface.rs"]
mod surface;

use std::sync::OnceLock;
use supple::bake::Mesher;
use supple::bake::mesh::{MeshQuality, ShellOptions};
use supple::export::write_smpl;
use supple::glam::{DMat3, DVec3};
use supple::load::read_smpl;
use supple::math::{Random, par_map, rotation_exp};
use supple::model::{Body, ParametricModel, Surface};
use supple::sample::SampleBody;
use surface::{
    components, dense_weights, edges, is_manifold, self_intersections, smallest_angle,
    winding_number,
};

/// About an edge's length, m.
const CELL: f64 = 0.02;

fn body() -> &'static SampleBody {
    static BODY: OnceLock<SampleBody> = OnceLock::new();
    BODY.get_or_init(|| supple::sample::body().expect("the built-in body is made"))
}

fn surface_of(positions: Vec<DVec3>) -> Surface {
    Surface {
        positions,
        triangles: body().model.triangles.clone(),
    }
}

fn skin() -> Surface {
    surface_of(body().model.template.clone())
}

fn joint(name: &str) -> usize {
    let names = &body().model.names;
    names.iter().position(|n| n == name).expect("a bone's name")
}

/// The same bone of the other side.
fn other_side(name: &str) -> String {
    match name.split_once('_') {
        Some(("left", rest)) => format!("right_{rest}"),
        Some(("right", rest)) => format!("left_{rest}"),
        _ => name.into(),
    }
}

fn mirrored(p: DVec3) -> DVec3 {
    DVec3::new(-p.x, p.y, p.z)
}

/// Only β_k, at `value`.
fn betas(k: usize, value: f64) -> [f64; 10] {
    let mut betas = [0.0; 10];
    betas[k] = value;
    betas
}

#[test]
fn the_skin_is_one_closed_manifold_sphere_of_smpls_size() {
    let skin = skin();
    assert_eq!((skin.positions.len(), skin.triangles.len()), (6890, 13776));
    assert!(skin.is_closed() && is_manifold(&skin));
    assert_eq!(components(&skin), 1);
    let euler = skin.positions.len() as i64 - edges(&skin.triangles).len() as i64
        + skin.triangles.len() as i64;
    assert_eq!(euler, 2, "genus 0");
    // Outward, and a slim person's: at the density of water 52 to 70 kg.
    let volume = skin.volume();
    assert!((0.052..0.070).contains(&volume), "{volume} m³");
    assert_eq!(self_intersections(&skin, CELL), 0);
    for t in 0..skin.triangles.len() {
        let smallest = smallest_angle(skin.corners(t)).to_degrees();
        assert!(smallest > 12.0, "triangle {t}: {smallest}°");
    }
}

#[test]
fn it_is_its_own_mirror_image() {
    let SampleBody { model, twin, .. } = body();
    let mut of_twins: Vec<[u32; 3]> = (model.triangles.iter())
        .map(|&[a, b, c]| [a, c, b].map(|v| twin[v as usize]))
        .collect();
    let mut triangles = model.triangles.clone();
    for list in [&mut of_twins, &mut triangles] {
        list.iter_mut().for_each(|t| {
            let smallest = (0..3).min_by_key(|&k| t[k]).expect("three corners");
            t.rotate_left(smallest);
        });
        list.sort_unstable();
    }
    assert!(of_twins == triangles);
    let others: Vec<usize> = (model.names.iter().map(|n| joint(&other_side(n)))).collect();
    for v in 0..model.template.len() {
        let t = twin[v] as usize;
        assert_eq!(twin[t] as usize, v);
        assert_eq!(mirrored(model.template[v]), model.template[t]);
        assert_eq!(t == v, model.template[v].x == 0.0);
        let of = |v: usize, bone: usize| -> f64 {
            let row = model.weights.row(v).iter();
            row.filter(|w| w.bone as usize == bone)
                .map(|w| w.weight)
                .sum()
        };
        for bone in 0..24 {
            assert!((of(v, bone) - of(t, others[bone])).abs() < 1e-12);
        }
        for direction in &model.shape_directions {
            assert!(mirrored(direction[v]).distance(direction[t]) < 1e-15);
        }
    }
    // A mirrored pose makes the mirrored body: the pose directions take part in it.
    let mut random = Random::new(11);
    let turn: Vec<DVec3> = (0..24).map(|_| random.vector(0.5)).collect();
    let pose: Vec<DMat3> = turn.iter().map(|r| rotation_exp(*r)).collect();
    let image: Vec<DMat3> = (0..24)
        .map(|j| turn[others[j]])
        .map(|r| rotation_exp(DVec3::new(r.x, -r.y, -r.z)))
        .collect();
    let [here, there] = [pose, image].map(|p| model.evaluate(&[], &p, DVec3::ZERO));
    let off = (0..here.len())
        .map(|v| mirrored(here[v]).distance(there[twin[v] as usize]))
        .fold(0.0, f64::max);
    assert!(off < 1e-9, "{off} m");
}

#[test]
fn its_proportions_are_a_persons() {
    let model = &body().model;
    let (points, joints) = (&model.template, model.joints(&model.template));
    let top = points.iter().map(|p| p.y).fold(f64::MIN, f64::max);
    let sole = points.iter().map(|p| p.y).fold(f64::MAX, f64::min);
    assert!(
        (1.70..1.74).contains(&top) && sole.abs() < 5e-3,
        "{sole} {top}"
    );
    let in_range = |what: &str, value: f64, range: std::ops::Range<f64>| {
        assert!(
            range.contains(&(value / top)),
            "{what}: {} of the height",
            value / top
        );
    };
    // The chin: the lowest point of the face's front on the midline.
    let midline = || points.iter().filter(|p| p.x == 0.0);
    let chin = midline().filter(|p| p.z > 0.07 && p.y > 1.4).map(|p| p.y);
    in_range("head", top - chin.fold(f64::MAX, f64::min), 0.125..0.142);
    let crotch = midline().map(|p| p.y).fold(f64::MAX, f64::min);
    in_range("crotch", crotch, 0.46..0.49);
    in_range("knee", joints[joint("left_knee")].y, 0.27..0.30);
    in_range(
        "shoulders",
        2.0 * joints[joint("left_shoulder")].x,
        0.18..0.22,
    );
    let reach = points.iter().map(|p| p.x).fold(f64::MIN, f64::max);
    in_range("span", 2.0 * reach, 0.98..1.04);
    // Arms down, the fingertips reach the middle of the thigh.
    let shoulder = joints[joint("left_shoulder")];
    let tips = shoulder.y - (reach - shoulder.x);
    let thigh = [joints[joint("left_knee")].y, joints[joint("left_hip")].y];
    let along = (tips - thigh[0]) / (thigh[1] - thigh[0]);
    assert!((0.35..0.65).contains(&along), "{along}");
    // What lies in front of the ankles is longer than what lies behind.
    let ankle = joints[joint("left_ankle")];
    let foot = || points.iter().filter(|p| p.y < 0.05);
    let toes = foot().map(|p| p.z).fold(f64::MIN, f64::max) - ankle.z;
    let heel = ankle.z - foot().map(|p| p.z).fold(f64::MAX, f64::min);
    assert!(toes > 2.5 * heel && heel > 0.03, "{toes} {heel}");
    // The nose is the face's foremost point.
    let nose = (points.iter().filter(|p| p.y > 1.45)).max_by(|a, b| a.z.total_cmp(&b.z));
    let nose = *nose.expect("a head");
    assert!(
        nose.x.abs() < 0.01 && (1.55..1.60).contains(&nose.y),
        "{nose}"
    );
}

#[test]
fn legs_and_fingers_stay_apart() {
    let (skin, joints) = (skin(), body().model.joints(&body().model.template));
    let knees = 0.5 * (joints[joint("left_knee")] + joints[joint("right_knee")]);
    assert!(winding_number(knees, &skin).abs() < 1e-6);
    // On an arc about the wrist through the middle of the fingers: five fingers (the thumb ends before).
    let wrist = joints[joint("left_wrist")];
    let count = |reach: f64| {
        let inside = (-90..=90).map(|degree: i32| {
            let (sin, cos) = f64::from(degree).to_radians().sin_cos();
            // Fingers hang a little: anywhere below the wrist's height counts.
            (-9..=6).any(|k| {
                let p = wrist + DVec3::new(reach * cos, 0.005 * f64::from(k), reach * sin);
                winding_number(p, &skin) > 0.5
            })
        });
        let inside: Vec<bool> = inside.collect();
        inside.windows(2).filter(|w| !w[0] && w[1]).count()
    };
    assert_eq!((count(0.06), count(0.118), count(0.14)), (1, 5, 4));
}

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
    let joints = model.joints(&model.template);
    let skin = skin();
    for (j, row) in model.joint_regressor.iter().enumerate() {
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

#[test]
fn shaped_bodies_stay_closed_with_a_sound_layer() {
    let model = &body().model;
    let shapes: Vec<(usize, f64)> = (0..10).flat_map(|k| [(k, -2.0), (k, 2.0)]).collect();
    let found = par_map(shapes.len(), |n| {
        let (k, value) = shapes[n];
        let shaped = surface_of(model.shaped(&betas(k, value)));
        let joints = model.skeleton(&betas(k, value)).joints;
        let outside = joints
            .iter()
            .filter(|j| winding_number(**j, &shaped) < 0.5)
            .count();
        (self_intersections(&shaped, CELL), shaped.volume(), outside)
    });
    for ((k, value), (crossings, volume, outside)) in shapes.iter().zip(found) {
        assert_eq!(crossings, 0, "direction {k} at {value}");
        assert!(volume > 0.035 && outside == 0, "direction {k} at {value}");
    }
    // A thin and a stout person's layer.
    let mesher = Mesher::PrismShell(ShellOptions {
        layers: Some(1),
        ..ShellOptions::default()
    });
    for value in [-2.0, 0.0, 2.0] {
        let mut body = Body::of_model("body", model, &betas(1, value), Vec::new());
        mesher.mesh(&mut body).unwrap();
        let quality = MeshQuality::of(&body.layer.mesh);
        assert_eq!(quality.inverted, 0);
        // Three tets a triangle; in a deep fold no column fits, and the bone holds the skin.
        let (tets, whole) = (body.layer.mesh.tets.len(), 3 * model.triangles.len());
        assert!(
            tets <= whole && whole - tets < whole / 500,
            "{tets} of {whole}"
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
fn soft_parts_are_where_a_body_is_soft() {
    let SampleBody { model, soft, .. } = body();
    let areas = skin().vertex_areas();
    let area = |chosen: &dyn Fn(usize) -> bool| -> f64 {
        (0..areas.len())
            .filter(|&v| chosen(v))
            .map(|v| areas[v])
            .sum()
    };
    let share = area(&|v| soft[v]) / area(&|_| true);
    assert!((0.25..0.6).contains(&share), "{share}");
    let firm = ["left_hand", "right_wrist", "left_foot", "right_ankle"].map(joint);
    for (v, row) in model.weights.iter().enumerate() {
        let on_firm = row.iter().any(|w| firm.contains(&(w.bone as usize)));
        assert!(!(soft[v] && on_firm), "vertex {v}");
    }
}

#[test]
fn the_same_body_comes_out_every_time() {
    let again = supple::sample::body().expect("the built-in body is made");
    assert!(again == *body());
}
