//! The generated hand is a closed, well-formed, well-behaved hand.

use super::surface;

use crate::SampleHand;
use std::sync::OnceLock;
use supple::glam::{DMat3, DVec3};
use supple::model::Surface;
use supple_bake::{Joints, ParametricModel};
use surface::{
    Grid, assert_closed_sphere, components, crossing, dense_weights, distance_to_triangle, edges,
    is_manifold, self_intersections, smallest_angle, winding_number,
};

/// About an edge's length, m.
const CELL: f64 = 5e-3;

fn hand() -> &'static SampleHand {
    static HAND: OnceLock<SampleHand> = OnceLock::new();
    HAND.get_or_init(|| crate::hand().expect("the built-in hand is made"))
}

fn skin() -> Surface {
    let model = &hand().model;
    Surface {
        positions: model.template.clone(),
        triangles: model.triangles.clone(),
    }
}

#[test]
fn the_skin_is_one_closed_manifold_sphere_of_manos_size() {
    let skin = skin();
    assert_eq!((skin.positions.len(), skin.triangles.len()), (3106, 6208));
    assert_closed_sphere(&skin, CELL);
    // Outward: the volume is positive, and a hand's (a hand of 19 cm displaces 0.3 to 0.45 l).
    let volume = skin.volume();
    assert!((3.0e-4..4.5e-4).contains(&volume), "{volume} m³");
    let longest = skin.positions.iter().map(|p| p.x).fold(0.0, f64::max);
    assert!((0.185..0.195).contains(&longest), "{longest} m");
}

#[test]
fn its_triangles_are_even() {
    let skin = skin();
    for t in 0..skin.triangles.len() {
        let smallest = smallest_angle(skin.corners(t));
        assert!(smallest.to_degrees() > 15.0, "triangle {t}: {smallest} rad");
    }
    let lengths = edges(&skin.triangles);
    let length =
        |(i, j): (u32, u32)| skin.positions[i as usize].distance(skin.positions[j as usize]);
    assert!(lengths.iter().all(|&e| (5e-4..1.1e-2).contains(&length(e))));
}

#[test]
fn fingers_stay_apart() {
    // Half way between neighbours, from beyond the web to the tips, there is air.
    let joints = hand().model.joints(&[]);
    let at = |digit: usize, segment: usize, fraction: f64| {
        let j = 1 + 3 * digit + segment;
        joints[j].lerp(joints[j + 1], fraction)
    };
    let surface = skin();
    for (a, b) in [(0, 1), (1, 3), (3, 2), (4, 0)] {
        for (segment, fraction) in [(0, 0.75), (1, 0.0), (1, 0.5), (1, 1.0)] {
            if a == 4 && segment == 0 {
                continue; // the thumb's metacarpal lies in the palm
            }
            let middle = 0.5 * (at(a, segment, fraction) + at(b, segment, fraction));
            let inside = winding_number(middle, &surface).abs();
            assert!(inside < 1e-6, "digits {a} and {b} are fused at {middle}");
        }
    }
    // From no point of the skin does the outward normal meet the skin again within 2 mm.
    let skin = skin();
    let grid = Grid::new(&skin, CELL);
    for (v, (&p, n)) in skin.positions.iter().zip(skin.vertex_normals()).enumerate() {
        let (from, way) = (p + 1e-4 * n, 1.9e-3 * n);
        for t in grid.near(&[from, from + way]) {
            let own = skin.triangles[t].contains(&(v as u32));
            let hit = crossing(from, way, skin.corners(t));
            assert!(own || hit.is_none(), "vertex {v} at {p}");
        }
    }
}

#[test]
fn bones_are_closed_and_lie_inside_the_skin() {
    let skin = skin();
    let hand = hand();
    assert_eq!(hand.bones.len(), 16);
    for (j, bone) in hand.bones.iter().enumerate() {
        let name = &hand.model.names[j];
        assert!(bone.is_closed() && is_manifold(bone), "{name}");
        assert!(bone.volume() > 0.0, "{name} points inward");
        assert_eq!(components(bone), if j == 0 { 7 } else { 1 }, "{name}");
        assert!(self_intersections(bone, CELL) == 0, "{name}");
        for &p in bone.positions.iter().step_by(3) {
            let clearance = (0..skin.triangles.len())
                .map(|t| distance_to_triangle(p, skin.corners(t)))
                .fold(f64::MAX, f64::min);
            assert!(clearance > 1.5e-3, "{name}: {clearance} m at {p}");
        }
        // Far from the surface on one side of it: one point tells for the component.
        assert!(
            (winding_number(bone.positions[0], &skin) - 1.0).abs() < 1e-6,
            "{name}"
        );
    }
}

#[test]
fn bones_do_not_enter_each_other() {
    for (a, bone) in hand().bones.iter().enumerate() {
        for (b, other) in hand().bones.iter().enumerate() {
            let low = other.positions.iter().fold(DVec3::MAX, |l, p| l.min(*p));
            let high = other.positions.iter().fold(DVec3::MIN, |h, p| h.max(*p));
            let in_box = |p: &&DVec3| p.cmpge(low).all() && p.cmple(high).all();
            for &p in bone.positions.iter().filter(in_box).filter(|_| a != b) {
                let inside = winding_number(p, other) > 0.5;
                assert!(!inside, "bone {a} enters bone {b} at {p}");
            }
        }
    }
}

#[test]
fn weights_are_a_smooth_partition_without_seams() {
    let model = &hand().model;
    let dense = dense_weights::<16>(model, 4);
    for (i, j) in edges(&model.triangles) {
        let (a, b) = (&dense[i as usize], &dense[j as usize]);
        let length = model.template[i as usize].distance(model.template[j as usize]);
        for k in 0..16 {
            // No seam: a weight takes at least 7 mm from 0 to 1.
            let slope = (a[k] - b[k]).abs() / length;
            assert!(slope < 1.0 / 7e-3, "bone {k}: {slope} 1/m on edge {i}–{j}");
        }
    }
    // The far segments of a digit know nothing of another digit.
    for weights in &dense {
        for digit in 0..5 {
            let far = weights[2 + 3 * digit] + weights[3 + 3 * digit];
            let others: f64 = (1..16)
                .filter(|k| (k - 1) / 3 != digit)
                .map(|k| weights[k])
                .sum();
            assert!(far < 0.6 || others == 0.0, "digit {digit}: {weights:?}");
        }
    }
    // Every bone moves something.
    for k in 0..16 {
        assert!(dense.iter().any(|w| w[k] > 0.9), "bone {k}");
    }
}

#[test]
fn the_tree_and_the_joints_are_manos() {
    let model = &hand().model;
    let parents: Vec<i64> = model
        .parents
        .iter()
        .map(|p| p.map_or(-1, i64::from))
        .collect();
    assert_eq!(
        parents,
        [-1, 0, 1, 2, 0, 4, 5, 0, 7, 8, 0, 10, 11, 0, 13, 14]
    );
    let joints = model.joints(&[]);
    assert!(joints[0].length() < 1e-6, "the wrist stands at the origin");
    // Fingers along +x, thumb side +y: index, middle, ring, pinky from the thumb's side.
    let order = [13, 1, 4, 10, 7];
    assert!(
        order
            .windows(2)
            .all(|w| joints[w[0] + 1].y > joints[w[1] + 1].y)
    );
    let Joints::Regressor(rows) = &model.joints else {
        panic!("the sample has a regressor")
    };
    for row in rows.iter() {
        assert!((row.iter().map(|r| r.1).sum::<f64>() - 1.0).abs() < 1e-6);
    }
    // A joint lies deep inside.
    let skin = skin();
    for joint in joints {
        assert!((winding_number(joint, &skin) - 1.0).abs() < 1e-6);
    }
}

/// Length of bone `j` to its child.
fn length(joints: &[DVec3], j: usize) -> f64 {
    joints[j].distance(joints[j + 1])
}

#[test]
fn shape_directions_make_clearly_different_hands() {
    let model = &hand().model;
    assert_eq!(model.shape_directions.len(), 10);
    let size = |d: &[DVec3]| d.iter().map(|v| v.length_squared()).sum::<f64>().sqrt();
    for (k, a) in model.shape_directions.iter().enumerate() {
        let largest = a.iter().map(|v| v.length()).fold(0.0, f64::max);
        assert!(largest > 7e-4, "direction {k} moves {largest} m at most");
        for (l, b) in model.shape_directions.iter().enumerate().take(k) {
            let cosine = a.iter().zip(b).map(|(u, v)| u.dot(*v)).sum::<f64>() / size(a) / size(b);
            assert!(cosine.abs() < 0.5, "directions {k} and {l}: {cosine}");
        }
    }
    // What the first ones are called is what they do.
    let rest = model.skeleton(&[]).joints;
    let of = |k: usize| {
        let mut betas = [0.0; 10];
        betas[k] = 2.0;
        model.skeleton(&betas).joints
    };
    let bigger = of(0);
    for j in [1, 2, 4, 5, 7, 8, 10, 11, 13, 14] {
        let growth = length(&bigger, j) / length(&rest, j);
        assert!(
            (growth - 1.11).abs() < 0.01,
            "size: bone {j} grows by {growth}"
        );
    }
    // At equal size, longer fingers go with a shorter palm.
    let longer = of(1);
    assert!(length(&longer, 4) / longer[4].length() > 1.1 * length(&rest, 4) / rest[4].length());
    let thumb = of(4);
    let growth = |j: usize| length(&thumb, j) / length(&rest, j);
    assert!(growth(13) > 1.1 * growth(4) && growth(14) > 1.1 * growth(5));
}

#[test]
fn shaped_hands_stay_closed_and_free_of_self_intersections() {
    let model = &hand().model;
    for k in 0..10 {
        for beta in [-2.0, 2.0] {
            let mut betas = [0.0; 10];
            betas[k] = beta;
            let shaped = Surface {
                positions: model.shaped(&betas),
                triangles: model.triangles.clone(),
            };
            assert!(shaped.volume() > 2e-4);
            assert_eq!(
                self_intersections(&shaped, CELL),
                0,
                "direction {k} at {beta}"
            );
            let skeleton = model.skeleton(&betas);
            for joint in skeleton.joints {
                assert!((winding_number(joint, &shaped) - 1.0).abs() < 1e-6);
            }
        }
    }
}

/// Local rotations that bend some bones towards the palm.
fn bent(model: &ParametricModel, angle: impl Fn(usize) -> f64) -> Vec<DMat3> {
    let joints = model.joints(&[]);
    (0..16)
        .map(|j| {
            if j == 0 {
                return DMat3::IDENTITY;
            }
            let along = match (j - 1) % 3 {
                2 => joints[j] - joints[j - 1],
                _ => joints[j + 1] - joints[j],
            };
            let dorsal = if j >= 13 {
                DVec3::new(-0.45, 0.55, 0.7)
            } else {
                DVec3::Z
            };
            DMat3::from_axis_angle(dorsal.cross(along).normalize(), angle(j).to_radians())
        })
        .collect()
}

#[test]
fn pose_directions_give_back_volume_that_linear_blending_loses() {
    let model = &hand().model;
    assert_eq!(model.pose_directions.len(), 135);
    let mut plain = model.clone();
    plain.pose_directions.clear();
    let volume = |model: &ParametricModel, pose: &[DMat3]| {
        Surface {
            positions: model.evaluate(&[], pose, DVec3::ZERO),
            triangles: model.triangles.clone(),
        }
        .volume()
    };
    let rest = skin().volume();
    let mut poses = Vec::new();
    for angle in [60.0, 75.0, 90.0] {
        // Each finger joint alone, then fists.
        for j in 1..13 {
            poses.push(bent(model, |i| if i == j { angle } else { 0.0 }));
        }
        poses.push(bent(model, |i| if i < 13 { angle } else { 20.0 }));
    }
    let (mut lost, mut left) = (0.0, 0.0);
    for pose in &poses {
        let without = rest - volume(&plain, pose);
        let with = rest - volume(model, pose);
        assert!(
            without > 0.0 && with.abs() < 0.6 * without,
            "{without} {with}"
        );
        lost += without;
        left += with.abs();
    }
    println!(
        "volume lost: {:.3} ml without, {:.3} ml with pose directions",
        1e6 * lost / poses.len() as f64,
        1e6 * left / poses.len() as f64
    );
    assert!(left < 0.3 * lost);
    // Nothing at rest.
    let identity = [DMat3::IDENTITY; 16];
    let error = model
        .evaluate(&[], &identity, DVec3::ZERO)
        .iter()
        .zip(&model.template)
        .map(|(a, b)| a.distance(*b))
        .fold(0.0, f64::max);
    assert!(error < 1e-15 + 1e-12, "{error}");
}

#[test]
fn pose_directions_are_local() {
    // Bending the little finger leaves the thumb alone, bit for bit in unposed space.
    let model = &hand().model;
    let pose = bent(model, |j| if (7..10).contains(&j) { 80.0 } else { 0.0 });
    let frames = model.skeleton(&[]).forward_kinematics(&pose, DVec3::ZERO);
    let unposed = model.unposed(&[], &frames);
    for (v, row) in model.weights.iter().enumerate() {
        if row.iter().all(|w| w.bone >= 13) {
            assert!(unposed[v].distance(model.template[v]) < 1e-12, "vertex {v}");
        }
    }
}

#[test]
fn the_palmar_side_is_a_sensible_part_of_the_skin() {
    let hand = hand();
    let skin = skin();
    let areas = skin.vertex_areas();
    let normals = skin.vertex_normals();
    let palmar: f64 = areas
        .iter()
        .zip(&hand.palmar)
        .filter(|(_, p)| **p)
        .map(|(a, _)| a)
        .sum();
    let share = palmar / areas.iter().sum::<f64>();
    assert!((0.2..0.5).contains(&share), "{share}");
    for v in 0..skin.positions.len() {
        let fingers_or_palm = hand.model.weights.row(v).iter().all(|w| w.bone < 13);
        if hand.palmar[v] && fingers_or_palm {
            assert!(normals[v].z < 0.0 && skin.positions[v].x > 0.0);
        }
    }
}

#[test]
fn the_same_hand_comes_out_every_time() {
    let again = crate::hand().expect("the built-in hand is made");
    assert!(again == *hand());
    // Quantised to a micrometre, so that a last bit of another machine's mathematics does not count.
    let quantised: Vec<u8> = again
        .model
        .template
        .iter()
        .flat_map(|p| (1e6 * *p).round().to_array().map(|c| c as i32))
        .flat_map(i32::to_le_bytes)
        .collect();
    println!("crc32 of the template in µm: {:08x}", crc32(&quantised));
}

/// CRC-32 (IEEE), bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0u32, |crc, &b| {
        (0..8).fold(crc ^ u32::from(b), |c, _| {
            (c >> 1) ^ (0xedb8_8320 & (c & 1).wrapping_neg())
        })
    })
}
