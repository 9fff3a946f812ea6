//! How a hand bends.

use super::anatomy::Digit;
use crate::pose_columns::Bends;
use glam::{DMat3, DVec3};
use std::f64::consts::PI;
use supple::internal::math::Random;
use supple::model::JointRange;

/// Unit direction of bone `j`.
fn along(digits: &[Digit; 5], j: usize) -> DVec3 {
    let (joints, segment) = (&digits[(j - 1) / 3].joints, (j - 1) % 3);
    (joints[segment + 1] - joints[segment]).normalize()
}

/// Rotation of bone `j` relative to its parent: flexion towards the palm, abduction towards the thumb
/// side, twist about the bone, degrees.
pub(super) fn bend(digits: &[Digit; 5], j: usize, degrees: [f64; 3]) -> DMat3 {
    let digit = &digits[(j - 1) / 3];
    let along = along(digits, j);
    let flexion_axis = digit.dorsal.cross(along).normalize();
    let dorsal = along.cross(flexion_axis);
    let [flexion, abduction, twist] = degrees.map(f64::to_radians);
    DMat3::from_axis_angle(flexion_axis, flexion)
        * DMat3::from_axis_angle(dorsal, abduction)
        * DMat3::from_axis_angle(along, twist)
}

/// Flexion that each segment can reach, degrees: (least, most), and its abduction, for a finger and
/// for the thumb.
const FINGER: [(f64, f64, f64); 3] = [(-15.0, 90.0, 12.0), (0.0, 100.0, 0.0), (-5.0, 75.0, 0.0)];
const THUMB: [(f64, f64, f64); 3] = [(-15.0, 30.0, 20.0), (-5.0, 60.0, 5.0), (-10.0, 80.0, 0.0)];

/// The range that bone `j` of a digit bends in, about its own axes of flexion, abduction and twist.
pub(super) fn range(digits: &[Digit; 5], j: usize) -> JointRange {
    /// Joints give way a little beyond what a hand is posed to, and shape directions turn their axes; degrees.
    const SLACK: f64 = 10.0;
    let (least, most, abduction) = flexion(j);
    let along = along(digits, j);
    let axis = digits[(j - 1) / 3].dorsal.cross(along).normalize();
    let radians = |flexion: f64, side: f64| {
        DVec3::new(flexion, side * (abduction + SLACK), side * SLACK) * (PI / 180.0)
    };
    JointRange::Axes {
        axes: DMat3::from_cols(axis, along.cross(axis), along),
        least: radians(least - SLACK, -1.0),
        most: radians(most + SLACK, 1.0),
    }
}

/// Least and most flexion of bone `j`, and its abduction, degrees.
fn flexion(j: usize) -> (f64, f64, f64) {
    let ranges = if j >= 13 { THUMB } else { FINGER };
    ranges[(j - 1) % 3]
}

impl Bends for [Digit; 5] {
    fn most_bulge(&self) -> f64 {
        2.5e-3
    }

    fn random(&self, random: &mut Random, j: usize) -> DMat3 {
        let (least, most, abduction) = flexion(j);
        let degrees = [
            random.uniform(least, most),
            random.uniform(-1.0, 1.0) * abduction,
            random.uniform(-4.0, 4.0),
        ];
        bend(self, j, degrees)
    }

    fn along(&self, j: usize) -> DVec3 {
        along(self, j)
    }
}
