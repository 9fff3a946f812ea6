//! The flat-ended cylinder: with ρ = √(x² + y²) and q = (ρ − r, |z| − l), d = |max(q, 0)| outside and
//! max(q_ρ, q_z) inside; the normal is that of the nearest face, or away from the rim.

use super::{SignedDistance, length_and_direction};
use glam::{DMat3, DVec3};

/// (ρ, radial direction, q_ρ, q_z, ±e_z on the point's side).
fn split(radius: f64, half_length: f64, point: DVec3) -> (f64, DVec3, f64, f64, DVec3) {
    let (rho, radial) = length_and_direction(DVec3::new(point.x, point.y, 0.0), DVec3::X);
    let axial = DVec3::Z * if point.z < 0.0 { -1.0 } else { 1.0 };
    (
        rho,
        radial,
        rho - radius,
        point.z.abs() - half_length,
        axial,
    )
}

pub(super) fn signed_distance(radius: f64, half_length: f64, point: DVec3) -> SignedDistance {
    let (_, radial, q_rho, q_z, axial) = split(radius, half_length, point);
    let (distance, normal) = if q_rho > 0.0 && q_z > 0.0 {
        let (d, n) = length_and_direction(DVec3::new(q_rho, 0.0, q_z), DVec3::X);
        (d, n.x * radial + n.z * axial)
    } else if q_rho > q_z {
        (q_rho, radial)
    } else {
        (q_z, axial)
    };
    SignedDistance { distance, normal }
}

pub(super) fn curvature(radius: f64, half_length: f64, point: DVec3) -> DMat3 {
    let (rho, radial, q_rho, q_z, axial) = split(radius, half_length, point);
    if rho == 0.0 || (q_z >= q_rho && q_rho <= 0.0) {
        return DMat3::ZERO;
    }
    let hoop = outer(DVec3::Z.cross(radial)) * rho.recip();
    if q_z <= 0.0 {
        return hoop;
    }
    let (d, n) = length_and_direction(DVec3::new(q_rho, 0.0, q_z), DVec3::X);
    // Around the rim: a circle of radius d in the (ρ, z) plane.
    outer(n.z * radial - n.x * axial) * d.recip() + hoop * n.x
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}
