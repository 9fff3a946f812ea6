//! Winding numbers of a point, from solid angles.

use glam::DVec3;
use std::f64::consts::TAU;

/// How often `triangles` wind around `point`: Σ of their signed solid angles over 4π, by
/// tan(Ω/2) = a·(b×c) / (|a||b||c| + (a·b)|c| + (b·c)|a| + (c·a)|b|)
/// (van Oosterom and Strackee 1983). A whole number where they are closed; with holes it is a smooth
/// function (Jacobson, Kavan and Sorkine-Hornung 2013).
pub fn winding_number(point: DVec3, triangles: impl Iterator<Item = [DVec3; 3]>) -> f64 {
    let half_angles = triangles.map(|corners| {
        let [a, b, c] = corners.map(|x| x - point);
        let [la, lb, lc] = [a, b, c].map(DVec3::length);
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        a.dot(b.cross(c)).atan2(below)
    });
    half_angles.sum::<f64>() / TAU
}
