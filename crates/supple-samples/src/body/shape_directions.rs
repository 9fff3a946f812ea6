//! Ten directions in which bodies differ, as smooth motions of skin and joints; one unit is about one
//! standard deviation.
//!
//! Bones grow affinely ([`growth`]) and soft parts swell ([`swelling`]); the floor stays where it is.

use super::anatomy::{self, BONES, NAMES, mirrored, parent};
use super::skin::Skin;
use crate::field::{Axes, smoothstep};
use crate::shape_motion::{Growth, Motion, blended, joined_motions, orthogonalise};
use glam::{DMat3, DVec3};
use supple::internal::math::Rows;
use supple::model::SkinWeight;

/// Number of directions.
pub(super) const COUNT: usize = 10;

/// What a bone belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Part {
    Pelvis,
    Spine,
    Chest,
    Collar,
    Neck,
    Head,
    Leg,
    Foot,
    Arm,
    Hand,
}

fn part(bone: usize) -> Part {
    match NAMES[bone]
        .trim_start_matches("left_")
        .trim_start_matches("right_")
    {
        "pelvis" => Part::Pelvis,
        "spine1" | "spine2" => Part::Spine,
        "spine3" => Part::Chest,
        "collar" => Part::Collar,
        "neck" => Part::Neck,
        "head" => Part::Head,
        "hip" | "knee" => Part::Leg,
        "ankle" | "foot" => Part::Foot,
        "shoulder" | "elbow" => Part::Arm,
        _ => Part::Hand,
    }
}

/// Relative growth along the bone, across it (of the trunk: sideways) and dorsally in direction `k`.
fn growth(k: usize, bone: usize) -> [f64; 3] {
    use Part::{Arm, Chest, Collar, Foot, Hand, Head, Leg, Neck, Pelvis, Spine};
    match (k, part(bone)) {
        // Stature.
        (0, _) => [0.042; 3],
        // Weight; bellies, breasts and buttocks swell besides.
        (1, Pelvis | Spine | Chest) => [0.0, 0.085, 0.12],
        (1, Collar) => [0.0, 0.06, 0.06],
        (1, Leg) => [0.0, 0.10, 0.10],
        (1, Arm) => [0.0, 0.12, 0.12],
        (1, Neck) => [0.0, 0.07, 0.06],
        (1, Hand | Foot) => [0.0, 0.03, 0.03],
        (1, Head) => [0.0, 0.02, 0.01],
        // Long legs, short trunk.
        (2, Leg) => [0.05, 0.0, 0.0],
        (2, Pelvis | Spine | Chest) => [-0.04, 0.0, 0.0],
        // Broad shoulders, narrow hips.
        (3, Collar) => [0.09, 0.03, 0.03],
        (3, Chest) => [0.0, 0.05, 0.02],
        (3, Pelvis) => [0.0, -0.05, -0.02],
        // Head.
        (8, Head) => [0.06; 3],
        (8, Neck) => [0.0, 0.03, 0.03],
        // Long arms and large hands.
        (9, Arm) => [0.055, 0.0, 0.0],
        (9, Hand) => [0.05; 3],
        _ => [0.0; 3],
    }
}

/// The frame that a bone grows in: along it, sideways, dorsally.
fn frame(bone: usize, joints: &[DVec3]) -> DMat3 {
    let along = match part(bone) {
        Part::Collar => joints[bone + 3] - joints[bone],
        Part::Leg | Part::Arm => {
            joints[(1..BONES)
                .find(|&j| parent(j) == Some(bone as u32))
                .unwrap_or(bone)]
                - joints[bone]
        }
        Part::Hand => joints[bone] - joints[parent(bone).map_or(0, |p| p as usize)],
        Part::Foot => DVec3::Z,
        _ => DVec3::Y,
    };
    let dorsal = if part(bone) == Part::Foot {
        DVec3::Y
    } else {
        DVec3::Z
    };
    let axes = Axes::new(DVec3::ZERO, along, dorsal);
    DMat3::from_cols(axes.axis, axes.lateral, axes.dorsal)
}

/// The motion of every bone in direction `k`.
fn motions(k: usize, joints: &[DVec3]) -> Vec<Motion> {
    let grows: Vec<Growth> = (0..BONES)
        .map(|bone| Growth {
            frame: frame(bone, joints),
            rate: growth(k, bone).into(),
        })
        .collect();
    let motions = joined_motions(&grows, joints, parent);
    // The sole under the left ankle stays on the floor.
    let ankle = joints[7];
    let sole = motions[7].at(DVec3::new(ankle.x, 0.0, ankle.z));
    let carry = DVec3::new(0.0, -sole.y, 0.0);
    motions.into_iter().map(|m| m.carried(carry)).collect()
}

/// 1 at `centre`, falling off over `radii`.
fn blob(p: DVec3, centre: [f64; 3], radii: [f64; 3]) -> f64 {
    (-((p - DVec3::from_array(centre)) / DVec3::from_array(radii)).length_squared()).exp()
}

/// Away from the axis of the trunk.
fn outward(p: DVec3) -> DVec3 {
    DVec3::new(p.x, 0.0, p.z + 10.0).normalize_or_zero()
}

/// Away from the axis of the left leg.
fn off_leg(p: DVec3) -> DVec3 {
    DVec3::new(p.x - 92.0, 0.0, p.z + 6.0).normalize_or_zero()
}

/// What the soft parts add in direction `k` at `p` (x ≥ 0), mm.
fn swelling(k: usize, p: DVec3) -> DVec3 {
    let breast =
        || blob(p, [80.0, 1270.0, 95.0], [58.0, 52.0, 70.0]) * DVec3::new(0.22, -0.12, 0.97);
    let belly = || blob(p, [0.0, 1010.0, 100.0], [125.0, 105.0, 110.0]) * outward(p);
    let flank = || blob(p, [130.0, 1020.0, -20.0], [60.0, 80.0, 90.0]) * outward(p);
    let buttock = || blob(p, [80.0, 880.0, -120.0], [80.0, 75.0, 70.0]) * outward(p);
    let hip = || blob(p, [165.0, 860.0, -10.0], [70.0, 95.0, 90.0]) * outward(p);
    let thigh = || blob(p, [92.0, 730.0, -6.0], [150.0, 150.0, 150.0]) * off_leg(p);
    match k {
        1 => 10.0 * belly() + 8.0 * flank() + 6.0 * buttock() + 5.0 * breast(),
        4 => 18.0 * breast(),
        5 => 24.0 * belly() + 8.0 * flank(),
        6 => muscles(p),
        7 => 13.0 * buttock() + 13.0 * hip() + 6.0 * thigh(),
        _ => DVec3::ZERO,
    }
}

/// Shoulders, arms, chest, back, thighs and calves swell, the waist shrinks.
fn muscles(p: DVec3) -> DVec3 {
    let axes = anatomy::arm();
    let local = axes.local(p);
    let off_arm = axes.world(DVec3::new(0.0, local.y, local.z)) - axes.origin;
    let on_arm = |at: f64, reach: f64| {
        let height = smoothstep((p.y - 1290.0) / 60.0);
        height * (-((local.x - at) / reach).powi(2)).exp() * off_arm.normalize_or_zero()
    };
    let on_leg = |y: f64, reach: f64| {
        let below = smoothstep((850.0 - p.y) / 120.0);
        below * (-((p.y - y) / reach).powi(2)).exp() * off_leg(p)
    };
    let chest = blob(p, [75.0, 1310.0, 85.0], [80.0, 55.0, 70.0]) * DVec3::Z;
    let back = blob(p, [120.0, 1280.0, -80.0], [70.0, 100.0, 70.0]) * outward(p);
    let neck = blob(p, [70.0, 1460.0, -45.0], [60.0, 45.0, 50.0]) * DVec3::new(0.5, 0.8, -0.2);
    let waist = blob(p, [100.0, 1060.0, 20.0], [120.0, 70.0, 140.0]) * outward(p);
    9.0 * on_arm(30.0, 60.0)
        + 8.0 * on_arm(150.0, 70.0)
        + 5.0 * on_arm(330.0, 60.0)
        + 7.0 * on_leg(660.0, 120.0)
        + 6.0 * on_leg(350.0, 70.0)
        + 11.0 * chest
        + 12.0 * back
        + 8.0 * neck
        - 6.0 * waist
}

/// `d` with its part towards the midline limited, so that no side crosses it: two units of it go less
/// than all the way.
fn kept_apart(d: DVec3, p: DVec3) -> DVec3 {
    if d.x >= 0.0 || p.x <= 0.0 {
        return DVec3::new(if p.x > 0.0 { d.x } else { 0.0 }, d.y, d.z);
    }
    let limit = 0.35 * p.x;
    DVec3::new(-limit * (-d.x / limit).tanh(), d.y, d.z)
}

/// Displacement of every vertex and every joint, mm a unit: `(skin[k], joints[k])`.
pub(super) fn shape_directions(
    joints: &[DVec3],
    skin: &Skin,
    weights: &Rows<SkinWeight>,
) -> (Vec<Vec<DVec3>>, Vec<Vec<DVec3>>) {
    let positions = &skin.surface.positions;
    let (mut vertices, mut moved): (Vec<Vec<DVec3>>, Vec<Vec<DVec3>>) = (0..COUNT)
        .map(|k| {
            let motions = motions(k, joints);
            let of_left = |v: usize| {
                let p = positions[v];
                kept_apart(blended(&motions, weights.row(v), p) + swelling(k, p), p)
            };
            let vertices = (0..positions.len())
                .map(|v| {
                    if positions[v].x < 0.0 {
                        mirrored(of_left(skin.twin[v] as usize))
                    } else {
                        of_left(v)
                    }
                })
                .collect();
            let moved = (0..BONES).map(|j| motions[j].at(joints[j])).collect();
            (vertices, moved)
        })
        .unzip();
    orthogonalise(&skin.surface.vertex_areas(), &mut vertices, &mut moved);
    (vertices, moved)
}
