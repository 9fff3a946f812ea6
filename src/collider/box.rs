//! The box: with q = |x| − b by component, d = |max(q, 0)| outside and max q inside; the normal is that
//! of the nearest face, or away from the nearest edge or corner.

use super::{SignedDistance, length_and_direction};
use glam::{DMat3, DVec3};

fn side(point: DVec3) -> DVec3 {
    DVec3::select(point.cmplt(DVec3::ZERO), DVec3::NEG_ONE, DVec3::ONE)
}

pub(super) fn signed_distance(half_extents: DVec3, point: DVec3) -> SignedDistance {
    let q = point.abs() - half_extents;
    let (distance, normal) = if q.max_element() > 0.0 {
        length_and_direction(q.max(DVec3::ZERO), DVec3::X)
    } else {
        let face = q.max_position();
        (q[face], DVec3::AXES[face])
    };
    SignedDistance {
        distance,
        normal: normal * side(point),
    }
}

pub(super) fn curvature(half_extents: DVec3, point: DVec3) -> DMat3 {
    let q = point.abs() - half_extents;
    if q.max_element() <= 0.0 {
        return DMat3::ZERO;
    }
    let (d, n) = length_and_direction(q.max(DVec3::ZERO), DVec3::X);
    let n = n * side(point);
    // Only directions that lead away from the box can turn the normal.
    let free = DVec3::select(q.cmpgt(DVec3::ZERO), DVec3::ONE, DVec3::ZERO);
    (DMat3::from_diagonal(free) - DMat3::from_cols(n * n.x, n * n.y, n * n.z)) * d.recip()
}
