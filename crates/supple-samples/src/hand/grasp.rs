//! A grasp made by the crate itself: poses of the sample hand as a tracker would send them.

use super::anatomy::{Digit, NAMES, digits};
use super::poses::bend;
use glam::{DMat3, DQuat, DVec3};
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use supple_files::{BonePose, BonePoses};

/// Time between two poses, s.
const EVERY: f64 = 0.05;
/// When the hand begins to close, is closed, begins to rise, and is up; the last pose, s.
const CLOSE: [f64; 2] = [0.1, 0.7];
const RISE: [f64; 2] = [0.8, 1.3];
const END: f64 = 3.3;
/// How high it rises, m.
const HEIGHT: f64 = 0.06;

/// Flexion, abduction and twist of a digit's three bones, degrees.
type Bent = [[f64; 3]; 3];

const fn flexed(a: f64, b: f64, c: f64) -> Bent {
    [[a, 0.0, 0.0], [b, 0.0, 0.0], [c, 0.0, 0.0]]
}

/// The thumb starts up, clear of the tube, and closes against it from the other side.
const THUMB: [Bent; 2] = [
    [[-10.0, 25.0, 0.0], [5.0, 0.0, 0.0], [0.0; 3]],
    [[11.0, 25.0, -2.0], [57.0, -13.0, 0.0], [30.0, 0.0, 0.0]],
];
/// Fingers open.
const OPEN: Bent = flexed(-8.0, 5.0, 0.0);
/// Index, middle, pinky, ring and thumb closed: by how much further than the surface of a tube of 20 mm radius the
/// fingers are bent, 8° to 12°, their springs press.
const CLOSED: [Bent; 5] = [
    flexed(38.0, 79.0, 32.0),
    flexed(44.0, 79.0, 40.0),
    flexed(16.0, 64.0, 34.0),
    flexed(33.0, 77.0, 37.0),
    THUMB[1],
];

/// The sample hand, thumb up, closes around a tube that stands before its palm, rises and keeps still; away from its
/// bind pose, z up.
pub fn grasp() -> Vec<BonePoses> {
    let digits = digits();
    let count = (END / EVERY).round() as usize;
    (0..=count)
        .map(|k| pose(&digits, EVERY * k as f64))
        .collect()
}

fn pose(digits: &[Digit; 5], time: f64) -> BonePoses {
    let thumb_up = DMat3::from_rotation_x(FRAC_PI_2);
    let wrist = BonePose {
        rotation: rounded(thumb_up),
        position: Some(DVec3::Z * in_millionths(HEIGHT * passed(RISE, time))),
    };
    let mut bones = BTreeMap::from([(NAMES[0].to_string(), wrist)]);
    let closed = passed(CLOSE, time);
    let mut rotation = thumb_up;
    for (j, name) in NAMES.iter().enumerate().skip(1) {
        let (digit, segment) = ((j - 1) / 3, (j - 1) % 3);
        if segment == 0 {
            rotation = thumb_up;
        }
        let open = if digit < 4 { OPEN } else { THUMB[0] };
        let [from, to] = [open, CLOSED[digit]].map(|bent| DVec3::from_array(bent[segment]));
        rotation *= bend(digits, j, from.lerp(to, closed).to_array());
        let pose = BonePose {
            rotation: rounded(rotation),
            position: None,
        };
        bones.insert((*name).to_string(), pose);
    }
    BonePoses {
        time: in_millionths(time),
        bones,
    }
}

/// How much of a span of time has passed, smoothly: u² (3 − 2u).
fn passed([from, to]: [f64; 2], time: f64) -> f64 {
    let u = ((time - from) / (to - from)).clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}

/// A tracker's digits, and the same on every machine.
fn in_millionths(x: f64) -> f64 {
    (1e6 * x).round() / 1e6
}

fn rounded(rotation: DMat3) -> Option<DQuat> {
    let components = DQuat::from_mat3(&rotation).to_array();
    Some(DQuat::from_array(components.map(in_millionths)))
}
