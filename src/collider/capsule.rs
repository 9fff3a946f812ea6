//! The ball swept along z: with a the nearest point of the axis, d = |x − a| − r, n = (x − a)/|x − a|.

use super::{SignedDistance, ball_curvature, length_and_direction};
use glam::{DMat3, DVec3};

fn from_axis(half_length: f64, point: DVec3) -> DVec3 {
    point - DVec3::Z * point.z.clamp(-half_length, half_length)
}

pub(super) fn signed_distance(radius: f64, half_length: f64, point: DVec3) -> SignedDistance {
    let (length, normal) = length_and_direction(from_axis(half_length, point), DVec3::X);
    SignedDistance {
        distance: length - radius,
        normal,
    }
}

pub(super) fn curvature(half_length: f64, point: DVec3) -> DMat3 {
    let (length, normal) = length_and_direction(from_axis(half_length, point), DVec3::X);
    let ball = ball_curvature(normal, length);
    if point.z.abs() >= half_length || length == 0.0 {
        return ball;
    }
    // Along the straight part only the hoop is curved.
    ball - DMat3::from_diagonal(DVec3::Z) * length.recip()
}
