//! The ball |x| < r: d = |x| − r, n = x/|x|.

use super::{SignedDistance, ball_curvature, length_and_direction};
use glam::{DMat3, DVec3};

pub(super) fn signed_distance(radius: f64, point: DVec3) -> SignedDistance {
    let (length, normal) = length_and_direction(point, DVec3::Z);
    SignedDistance {
        distance: length - radius,
        normal,
    }
}

pub(super) fn curvature(point: DVec3) -> DMat3 {
    let (length, normal) = length_and_direction(point, DVec3::Z);
    ball_curvature(normal, length)
}
