//! The skin as a surface: closed, symmetric, a person's proportions, apart where limbs are.

use super::{CELL, betas, body, joint, other_side, skin, surface_of};
use crate::SampleBody;
use crate::tests::surface::{
    assert_closed_sphere, self_intersections, smallest_angle, winding_number,
};
use supple::glam::{DMat3, DVec3};
use supple::internal::math::{Random, par_map, rotation_exp};
use supple_bake::mesh::{MeshQuality, ShellOptions};
use supple_bake::{Body, Mesher};

pub fn mirrored(p: DVec3) -> DVec3 {
    DVec3::new(-p.x, p.y, p.z)
}

#[test]
fn the_skin_is_one_closed_manifold_sphere_of_smpls_size() {
    let skin = skin();
    assert_eq!((skin.positions.len(), skin.triangles.len()), (6890, 13776));
    assert_closed_sphere(&skin, CELL);
    // Outward, and a slim person's: at the density of water 52 to 70 kg.
    let volume = skin.volume();
    assert!((0.052..0.070).contains(&volume), "{volume} m³");
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
    let (points, joints) = (&model.template, model.joints(&[]));
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
    let (skin, joints) = (skin(), body().model.joints(&[]));
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
