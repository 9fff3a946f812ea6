//! How a body bends.

use super::anatomy::{BONES, NAMES, mirrored, mirrored_bone, parent};
use crate::pose_columns::Bends;
use glam::{DMat3, DVec3};
use supple::internal::math::{Random, rotation_exp};
use supple::model::JointRange;

/// Where the joints are, mm.
pub(super) struct Joints<'a>(pub &'a [DVec3]);

/// Rotation that a joint can take about x (flexion of trunk and legs), y and z, degrees: least and most,
/// for the midline and the left side.
fn range(joint: &str) -> [[f64; 2]; 3] {
    match joint {
        "hip" => [[-100.0, 25.0], [-30.0, 30.0], [-10.0, 45.0]],
        "knee" => [[0.0, 130.0], [-8.0, 8.0], [-3.0, 3.0]],
        "ankle" => [[-25.0, 45.0], [-12.0, 12.0], [-15.0, 15.0]],
        "foot" => [[-40.0, 20.0], [-3.0, 3.0], [-3.0, 3.0]],
        "spine1" | "spine2" | "spine3" => [[-15.0, 35.0], [-20.0, 20.0], [-18.0, 18.0]],
        "neck" => [[-25.0, 30.0], [-30.0, 30.0], [-20.0, 20.0]],
        "head" => [[-25.0, 25.0], [-40.0, 40.0], [-15.0, 15.0]],
        "collar" => [[-8.0, 8.0], [-15.0, 15.0], [-8.0, 25.0]],
        "shoulder" => [[-40.0, 40.0], [-100.0, 30.0], [-85.0, 80.0]],
        "elbow" => [[-50.0, 50.0], [-130.0, 0.0], [-4.0, 4.0]],
        "wrist" => [[-10.0, 10.0], [-20.0, 20.0], [-60.0, 60.0]],
        // The fingers' roots.
        _ => [[-3.0, 3.0], [-3.0, 3.0], [-75.0, 15.0]],
    }
}

/// The range that bone `j` turns in, about the body's axes.
pub(super) fn limit(j: usize) -> JointRange {
    /// Joints give way a little beyond what a body is posed to, degrees.
    const SLACK: f64 = 10.0;
    let (side, name) = NAMES[j].split_once('_').unwrap_or(("", NAMES[j]));
    let ends = range(name).map(|[least, most]| [least - SLACK, most + SLACK].map(f64::to_radians));
    // A rotation's mirror image keeps the part about x.
    let ends = match side {
        "right" => [ends[0], ends[1].map(|e| -e), ends[2].map(|e| -e)],
        _ => ends,
    };
    JointRange::Axes {
        axes: DMat3::IDENTITY,
        least: DVec3::from_array(ends.map(|[a, b]| a.min(b))),
        most: DVec3::from_array(ends.map(|[a, b]| a.max(b))),
    }
}

impl Bends for Joints<'_> {
    fn most_bulge(&self) -> f64 {
        6e-3
    }

    fn random(&self, random: &mut Random, j: usize) -> DMat3 {
        let (side, name) = NAMES[j].split_once('_').unwrap_or(("", NAMES[j]));
        let [x, y, z] = range(name).map(|[least, most]| random.uniform(least, most).to_radians());
        // A rotation's mirror image keeps the part about x.
        let sign = if side == "right" { -1.0 } else { 1.0 };
        rotation_exp(DVec3::new(x, sign * y, sign * z))
    }

    fn along(&self, j: usize) -> DVec3 {
        let from = self.0[j];
        let child = (1..BONES).find(|&c| parent(c) == Some(j as u32));
        let way = match child {
            // The chest goes on to the neck.
            Some(_) if j == 9 => self.0[12] - from,
            Some(c) => self.0[c] - from,
            None => from - parent(j).map_or(DVec3::ZERO, |p| self.0[p as usize]),
        };
        way.normalize_or(DVec3::Y)
    }
}

/// The columns' mean with their mirror images, so that mirrored poses make mirrored bodies: the feature
/// (row a, column b of a joint's R − I) has the sign of its row times that of its column.
pub(super) fn symmetric_columns(columns: &[Vec<DVec3>], twin: &[u32]) -> Vec<Vec<DVec3>> {
    let sign = |axis: usize| if axis == 0 { -1.0 } else { 1.0 };
    (0..columns.len())
        .map(|k| {
            let (joint, entry) = (1 + k / 9, k % 9);
            let other = &columns[9 * (mirrored_bone(joint) - 1) + entry];
            let sign = sign(entry / 3) * sign(entry % 3);
            (0..twin.len())
                .map(|v| 0.5 * (columns[k][v] + sign * mirrored(other[twin[v] as usize])))
                .collect()
        })
        .collect()
}
