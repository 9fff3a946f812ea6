//! The body's joints and frames. Lengths in mm.
//!
//! Frame: floor y = 0, +y up, +z forward, +x to the person's left: SMPL's axes. The stature is 1.72 m, the
//! head 1/7.5 of it; segment lengths follow the ratios to stature of Drillis and Contini (1966). Arms are
//! stretched out and a little below the horizontal, palms down.

use crate::field::Axes;
use glam::DVec3;

/// Bone names in SMPL's order.
pub(super) const NAMES: [&str; BONES] = [
    "pelvis",
    "left_hip",
    "right_hip",
    "spine1",
    "left_knee",
    "right_knee",
    "spine2",
    "left_ankle",
    "right_ankle",
    "spine3",
    "left_foot",
    "right_foot",
    "neck",
    "left_collar",
    "right_collar",
    "head",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
    "left_hand",
    "right_hand",
];

/// Number of bones.
pub(super) const BONES: usize = 24;

/// Parent of each bone.
const PARENTS: [u32; BONES] = [
    u32::MAX,
    0,
    0,
    0,
    1,
    2,
    3,
    4,
    5,
    6,
    7,
    8,
    9,
    9,
    9,
    12,
    13,
    14,
    16,
    17,
    18,
    19,
    20,
    21,
];

/// Parent of bone `j`.
pub(super) fn parent(j: usize) -> Option<u32> {
    (j > 0).then(|| PARENTS[j])
}

/// The same bone of the other side.
pub(super) fn mirrored_bone(j: usize) -> usize {
    let other = match NAMES[j].split_once('_') {
        Some(("left", name)) => format!("right_{name}"),
        Some(("right", name)) => format!("left_{name}"),
        _ => return j,
    };
    NAMES.iter().position(|n| *n == other).unwrap_or(j)
}

/// The point across the plane of symmetry.
pub(super) fn mirrored(p: DVec3) -> DVec3 {
    DVec3::new(-p.x, p.y, p.z)
}

/// Joints of the midline and of the left side, with the name they have there.
const LEFT_AND_MIDDLE: [(usize, [f64; 3]); 15] = [
    (0, [0.0, 938.0, -2.0]),
    (1, [84.0, 872.0, -4.0]),
    (3, [0.0, 1055.0, -22.0]),
    (4, [93.0, 486.0, 2.0]),
    (6, [0.0, 1180.0, -30.0]),
    (7, [91.0, 76.0, -24.0]),
    (9, [0.0, 1268.0, -30.0]),
    (10, [102.0, 26.0, 96.0]),
    (12, [0.0, 1446.0, -32.0]),
    (13, [64.0, 1385.0, -22.0]),
    (15, [0.0, 1536.0, -6.0]),
    (16, [170.0, 1392.0, -24.0]),
    (18, [0.0; 3]),
    (20, [0.0; 3]),
    (22, [0.0; 3]),
];

/// Slope of the arms below the horizontal, rad, and lengths of upper arm, forearm and palm.
const ARM_SLOPE: f64 = 0.07;
const ARM: [f64; 3] = [268.0, 248.0, 88.0];

/// The left arm: from the shoulder along the arm, dorsal up.
pub(super) fn arm() -> Axes {
    let (sin, cos) = ARM_SLOPE.sin_cos();
    let shoulder = DVec3::from_array(LEFT_AND_MIDDLE[11].1);
    Axes::new(shoulder, DVec3::new(cos, -sin, 0.0), DVec3::Y)
}

/// Stations of elbow, wrist and the fingers' roots along the arm.
pub(super) fn arm_stations() -> [f64; 3] {
    [ARM[0], ARM[0] + ARM[1], ARM[0] + ARM[1] + ARM[2]]
}

/// All joints.
pub(super) fn joints() -> Vec<DVec3> {
    let mut all = vec![DVec3::ZERO; BONES];
    let (arm, stations) = (arm(), arm_stations());
    for (j, place) in LEFT_AND_MIDDLE {
        let place = match j {
            18 | 20 | 22 => arm.world(DVec3::new(stations[(j - 18) / 2], 0.0, 0.0)),
            _ => DVec3::from_array(place),
        };
        all[j] = place;
        all[mirrored_bone(j)] = mirrored(place);
    }
    // A joint of the midline is its own mirror image.
    for (j, place) in all.iter_mut().enumerate() {
        if mirrored_bone(j) == j {
            place.x = 0.0;
        }
    }
    all
}
