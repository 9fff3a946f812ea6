//! Animations between their keys and above the joints.

use super::evaluation::{frames_of, posed};
use super::fixture::*;
use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4};
use supple_files::{parse_gltf, parse_gltf_motions};

/// Adds a channel to the animation `move`.
fn channel(file: &mut Fixture, channel: (usize, &str, &str), times: &[f32], values: &[Vec<f32>]) {
    if file.json["animations"].is_null() {
        file.animation("move");
    }
    file.channel(0, channel, times, values);
}

fn floats(q: DQuat) -> Vec<f32> {
    q.to_array().map(|c| c as f32).to_vec()
}

/// A cubic Hermite spline by its Bernstein form: Bézier points v₀, v₀ + T out/3, v₁ − T in/3, v₁.
fn bezier(length: f64, [v0, out, into, v1]: [DVec4; 4], u: f64) -> DVec4 {
    let (b, c) = (v0 + length / 3.0 * out, v1 - length / 3.0 * into);
    let w = 1.0 - u;
    w * w * w * v0 + 3.0 * w * w * u * b + 3.0 * w * u * u * c + u * u * u * v1
}

#[test]
fn every_interpolation_and_nodes_above_the_joints() {
    let armature = (
        0.5,
        DQuat::from_rotation_x(-1.5),
        DVec3::new(0.3, 1.0, -0.2),
    );
    let mut file = bar_file(&BarFile {
        armature,
        ..BarFile::default()
    });
    let times = [0.5f32, 1.0, 1.5];
    let places = joint_places();
    // Node 0, above the joints, glides; bone 0 turns along arcs the long way round in sign; bone 1 jumps;
    // bone 2 swings on a spline and slides out on another.
    let glide = [[0.3, 1.0, -0.2], [0.5, 1.0, 0.1], [0.5, 1.4, 0.1]];
    let glide: Vec<Vec<f32>> = glide.iter().map(|v| v.to_vec()).collect();
    channel(&mut file, (0, "translation", "LINEAR"), &times, &glide);
    let turns = [0.0, 1.0, 2.5].map(|a| places[0].0 * DQuat::from_rotation_y(a));
    let arcs = [floats(turns[0]), floats(-turns[1]), floats(turns[2])];
    channel(&mut file, (1, "rotation", "LINEAR"), &times, &arcs);
    let jumps = [0.0, 0.5, -0.5].map(|a| places[1].0 * DQuat::from_rotation_z(a));
    channel(
        &mut file,
        (2, "rotation", "STEP"),
        &times,
        &jumps.map(floats),
    );
    let swings = [0.0, 0.4, -0.3].map(|a| places[2].0 * DQuat::from_rotation_x(a));
    let tangents = [
        [0.1, 0.0, 0.2, 0.0],
        [0.0, -0.3, 0.1, 0.2],
        [0.2, 0.1, 0.0, 0.0],
    ];
    let spline: Vec<Vec<f32>> = (0..3)
        .flat_map(|k| {
            let tangent = tangents[k].map(|c| c as f32).to_vec();
            [tangent.clone(), floats(swings[k]), tangent]
        })
        .collect();
    channel(&mut file, (3, "rotation", "CUBICSPLINE"), &times, &spline);
    let out = [0.0, 0.05, 0.02].map(|d| places[2].1 * (1.0 + d));
    let slide: Vec<Vec<f32>> = (0..3)
        .flat_map(|k| [DVec3::X, out[k], DVec3::X * 0.5].map(|v| v.as_vec3().to_array().to_vec()))
        .collect();
    channel(&mut file, (3, "translation", "CUBICSPLINE"), &times, &slide);

    let bytes = file.glb();
    let body = parse_gltf(&bytes, "bar.glb").unwrap().body(&[]).unwrap();
    let clips = parse_gltf_motions(&bytes, "bar.glb").unwrap();
    let [clip] = &clips[..] else {
        panic!("{}", clips.len())
    };
    assert_eq!(clip.name, "move");
    assert!((clip.duration() - 1.0).abs() < 1e-9);
    let bar = Bar::new(10, 0.05);
    let (joints, weights) = bar.influences();
    let bind = joint_worlds(DAffine3::IDENTITY, &[DQuat::IDENTITY; BONES]);
    for (f, frame) in clip.frames.iter().enumerate() {
        let time = 0.5 + clip.frame_time * f as f64;
        let k = if time < 1.0 - 1e-9 { 0 } else { 1 };
        let u = ((time - f64::from(times[k])) / 0.5).clamp(0.0, 1.0);
        let lerp = |a: f32, b: f32| f64::from(a) + u * f64::from(b - a);
        let place = [0, 1, 2].map(|c| lerp(glide[k][c], glide[k + 1][c]));
        // Turns about one axis: the angle runs linearly.
        let angle = [0.0, 1.0, 2.5][k] + u * [1.0, 1.5][k];
        let jump = if u > 1.0 - 1e-9 { k + 1 } else { k };
        let tangent = |k: usize| DVec4::from_array(tangents[k]);
        let swing = [
            swings[k].into(),
            tangent(k),
            tangent(k + 1),
            swings[k + 1].into(),
        ];
        let swing = bezier(0.5, swing, u).normalize();
        let ends = [out[k], DVec3::X * 0.5, DVec3::X, out[k + 1]];
        let slide = bezier(0.5, ends.map(|v| v.extend(0.0)), u).truncate();
        let mut world = DAffine3::from_scale_rotation_translation(
            DVec3::splat(armature.0),
            armature.1,
            DVec3::from_array(place),
        );
        let local = [
            (places[0].0 * DQuat::from_rotation_y(angle), places[0].1),
            (jumps[jump], places[1].1),
            (DQuat::from_vec4(swing), slide),
        ];
        let skinning: Vec<DMat4> = (0..BONES)
            .map(|j| {
                world *= DAffine3::from_rotation_translation(local[j].0, local[j].1);
                (world * bind[j].inverse()).into()
            })
            .collect();
        let found = posed(&body, &frames_of(&body, clip, frame));
        for (v, p) in bar.positions.iter().enumerate() {
            let place = |b: usize| {
                let joint = joints[v][b] as usize;
                f64::from(weights[v][b]) * skinning[joint].transform_point3(*p)
            };
            let distance = found[v].distance(place(0) + place(1));
            assert!(distance < 1e-6, "{time} s, vertex {v}: {distance:e}");
        }
    }
}

#[test]
fn what_moves_no_bone_is_left_out() {
    let mut file = bar_file(&BarFile::default());
    let places = [vec![0.0; 3], vec![1.0; 3]];
    channel(
        &mut file,
        (4, "translation", "LINEAR"),
        &[0.0, 1.0],
        &places,
    );
    assert!(
        parse_gltf_motions(&file.glb(), "bar.glb")
            .unwrap()
            .is_empty()
    );
}
