//! Rotations as vectors (angle × axis, rad).

use glam::{DMat3, DQuat, DVec3};

/// The matrix \[v\]× with \[v\]× a = v × a.
pub fn skew(v: DVec3) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(0.0, v.z, -v.y),
        DVec3::new(-v.z, 0.0, v.x),
        DVec3::new(v.y, -v.x, 0.0),
    )
}

/// exp(\[v\]×): the rotation by |v| rad about v.
pub fn rotation_exp(v: DVec3) -> DMat3 {
    DMat3::from_quat(DQuat::from_scaled_axis(v))
}

/// The rotation vector of `r`, of length in \[0, π\]; the inverse of [`rotation_exp`].
pub fn rotation_log(r: DMat3) -> DVec3 {
    // q and −q are one rotation: w ≥ 0 picks the shorter way round.
    let q = DQuat::from_mat3(&r).normalize();
    let q = if q.w < 0.0 { -q } else { q };
    let sine = q.xyz().length();
    if sine < 1e-12 {
        return 2.0 * q.xyz();
    }
    q.xyz() * (2.0 * sine.atan2(q.w) / sine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use std::f64::consts::PI;

    #[test]
    fn log_inverts_exp_from_tiny_angles_to_near_pi() {
        for angle in [1e-14, 1e-9, 1e-4, 0.3, 1.5, 3.1, PI - 1e-6] {
            let v = DVec3::new(0.6, -0.48, 0.64) * angle;
            let back = rotation_log(rotation_exp(v));
            assert_relative_eq!((back - v).length(), 0.0, epsilon = 1e-9 * angle.max(1e-3));
        }
    }

    #[test]
    fn skew_is_the_cross_product_and_the_derivative_of_exp() {
        let (v, a) = (DVec3::new(0.3, -0.2, 0.7), DVec3::new(-1.0, 0.4, 0.25));
        assert_relative_eq!((skew(v) * a - v.cross(a)).length(), 0.0, epsilon = 1e-15);
        let step = 1e-6;
        let difference = (rotation_exp(v * step) * a - rotation_exp(-v * step) * a) / (2.0 * step);
        assert_relative_eq!((difference - skew(v) * a).length(), 0.0, epsilon = 1e-9);
    }
}
