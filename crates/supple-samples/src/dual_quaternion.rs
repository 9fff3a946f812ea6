//! Skinning by dual quaternions (Kavan, Collins, Žára and O'Sullivan 2007): blends rigid motions into a
//! rigid motion, so that sections of a limb keep their size.

use glam::{DMat3, DQuat, DVec3};

/// Where bones carry `point`: bones as (weight, rotation, joint place,
/// reference joint).
pub(super) fn dual_quaternion_skin(
    point: DVec3,
    bones: impl Iterator<Item = (f64, DMat3, DVec3, DVec3)>,
) -> DVec3 {
    let (mut real, mut dual) = (DQuat::from_array([0.0; 4]), DQuat::from_array([0.0; 4]));
    for (weight, rotation, position, joint) in bones {
        let mut q = DQuat::from_mat3(&rotation);
        // q and −q are one rotation: blend on one side of the sphere.
        if real.dot(q) < 0.0 {
            q = -q;
        }
        let t = position - rotation * joint;
        let translation = DQuat::from_xyzw(t.x, t.y, t.z, 0.0);
        real += q * weight;
        dual += (translation * q) * (0.5 * weight);
    }
    let length = real.length();
    let (real, dual) = (real * (1.0 / length), dual * (1.0 / length));
    let t = (dual * real.conjugate()) * 2.0;
    real * point + DVec3::new(t.x, t.y, t.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn one_bone_and_equal_bones_move_rigidly() {
        let rotation = supple::internal::math::rotation_exp(DVec3::new(0.4, -2.1, 0.9));
        let (position, joint) = (DVec3::new(0.1, 0.2, -0.3), DVec3::new(0.05, 0.0, 0.02));
        let point = DVec3::new(0.3, -0.1, 0.2);
        let rigid = rotation * (point - joint) + position;
        for weights in [vec![1.0], vec![0.25, 0.75]] {
            let bones = weights.into_iter().map(|w| (w, rotation, position, joint));
            let moved = dual_quaternion_skin(point, bones);
            assert_relative_eq!((moved - rigid).length(), 0.0, epsilon = 1e-14);
        }
    }

    #[test]
    fn half_way_between_two_bones_lies_half_the_bend() {
        // Linear blending would shorten the offset by cos 45°.
        let joint = DVec3::new(1.0, 0.0, 0.0);
        let bend = DMat3::from_rotation_z(std::f64::consts::FRAC_PI_2);
        let half = DMat3::from_rotation_z(std::f64::consts::FRAC_PI_4);
        let point = joint + DVec3::new(0.0, 0.3, 0.1);
        let bones = [
            (0.5, DMat3::IDENTITY, joint, joint),
            (0.5, bend, joint, joint),
        ];
        let moved = dual_quaternion_skin(point, bones.into_iter());
        let expected = joint + half * (point - joint);
        assert_relative_eq!((moved - expected).length(), 0.0, epsilon = 1e-14);
    }
}
