//! Random poses that a hand can take.

use super::anatomy::{Digit, parent};
use crate::math::Random;
use glam::{DMat3, DVec3};

/// Rotation of bone `j` relative to its parent: flexion towards the palm, abduction towards the thumb
/// side, twist about the bone, degrees.
pub(super) fn bend(digits: &[Digit; 5], j: usize, degrees: [f64; 3]) -> DMat3 {
    let digit = &digits[(j - 1) / 3];
    let segment = (j - 1) % 3;
    let along = (digit.joints[segment + 1] - digit.joints[segment]).normalize();
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

/// Local rotations of a random pose: every joint bends with probability `busy`.
pub(super) fn random_pose(digits: &[Digit; 5], random: &mut Random, busy: f64) -> Vec<DMat3> {
    (0..16)
        .map(|j| {
            if parent(j).is_none() || random.uniform(0.0, 1.0) >= busy {
                return DMat3::IDENTITY;
            }
            let ranges = if j >= 13 { THUMB } else { FINGER };
            let (least, most, abduction) = ranges[(j - 1) % 3];
            let flexion = least + (most - least) * random.uniform(0.0, 1.0);
            let abduction = abduction * (2.0 * random.uniform(0.0, 1.0) - 1.0);
            let twist = 4.0 * (2.0 * random.uniform(0.0, 1.0) - 1.0);
            bend(digits, j, [flexion, abduction, twist])
        })
        .collect()
}

/// Dual-quaternion skinning of one point (Kavan et al. 2007): bones as (weight, rotation, joint place,
/// reference joint).
pub(super) fn dual_quaternion_skin(
    point: DVec3,
    bones: impl Iterator<Item = (f64, DMat3, DVec3, DVec3)>,
) -> DVec3 {
    use glam::DQuat;
    let (mut real, mut dual) = (DQuat::from_array([0.0; 4]), DQuat::from_array([0.0; 4]));
    for (weight, rotation, position, joint) in bones {
        let mut q = DQuat::from_mat3(&rotation);
        // q and −q are one rotation: blend on one side of the sphere.
        if real.dot(q) < 0.0 {
            q = -q;
        }
        let t = position - rotation * joint;
        let translation = DQuat::from_xyzw(t.x, t.y, t.z, 0.0);
        real = real + q * weight;
        dual = dual + (translation * q) * (0.5 * weight);
    }
    let length = real.length();
    let (real, dual) = (real * (1.0 / length), dual * (1.0 / length));
    let t = (dual * real.conjugate()) * 2.0;
    real * point + DVec3::new(t.x, t.y, t.z)
}
