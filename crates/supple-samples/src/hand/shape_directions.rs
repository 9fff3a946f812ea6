//! Ten directions in which hands differ, as smooth motions of skin and joints.
//!
//! Eight are affine maps of each bone, joined at the joints and blended by the skin weights; two swell
//! the skin: at the fingers' joints, and at the eminences of the palm. One unit is about one standard
//! deviation.

use super::anatomy::{Digit, parent};
use crate::field::Axes;
use crate::shape_motion::{Growth, Motion, blended, joined_motions, orthogonalise};
use glam::{DMat3, DVec3};
use supple::internal::math::Rows;
use supple::model::{SkinWeight, Surface};

/// Number of directions.
pub(super) const COUNT: usize = 10;

/// Relative growth of a bone along its axis, across it, and dorsally, in direction `k`.
fn growth(k: usize, bone: usize) -> [f64; 3] {
    let (root, thumb) = (bone == 0, bone >= 13);
    // Index 0, middle 1, pinky 2, ring 3, thumb 4; segment 0 is proximal.
    let (digit, segment) = if root {
        (5, 0)
    } else {
        ((bone - 1) / 3, (bone - 1) % 3)
    };
    match k {
        // Size.
        0 => [0.055; 3],
        // Length of the fingers.
        1 if !root => [if thumb { 0.02 } else { 0.07 }, 0.0, 0.0],
        // Thickness of the digits.
        2 => [
            0.0,
            if root { 0.015 } else { 0.08 },
            if root { 0.03 } else { 0.08 },
        ],
        // Width of the palm.
        3 if root => [0.0, 0.07, 0.0],
        // Length of the thumb.
        4 if thumb => [0.10, 0.0, 0.0],
        // Thickness of the palm.
        5 if root => [0.0, 0.0, 0.10],
        // Tapering of the fingers.
        6 if !root => {
            let thicker = [0.06, -0.02, -0.11][segment];
            [0.0, thicker, thicker]
        }
        // Long ulnar side.
        8 if !root => [[-0.06, 0.0, 0.10, 0.05, -0.02][digit], 0.0, 0.0],
        _ => [0.0; 3],
    }
}

/// The motion of every bone in direction `k`.
fn motions(k: usize, digits: &[Digit; 5], joints: &[DVec3]) -> Vec<Motion> {
    let grows: Vec<Growth> = (0..16)
        .map(|bone| {
            let axes = if bone == 0 {
                Axes::new(DVec3::ZERO, DVec3::X, DVec3::Z)
            } else {
                let digit = &digits[(bone - 1) / 3];
                let s = (bone - 1) % 3;
                Axes::new(
                    digit.joints[s],
                    digit.joints[s + 1] - digit.joints[s],
                    digit.dorsal,
                )
            };
            Growth {
                frame: DMat3::from_cols(axes.axis, axes.lateral, axes.dorsal),
                rate: growth(k, bone).into(),
            }
        })
        .collect();
    joined_motions(&grows, joints, parent)
}

/// Prominence of the fingers' joints, away from the digit's axis, mm: where two bones share a vertex.
fn knuckle(digits: &[Digit; 5], x: DVec3, row: &[SkinWeight]) -> DVec3 {
    let of_root: f64 = row.iter().filter(|w| w.bone == 0).map(|w| w.weight).sum();
    let Some(bone) = row.iter().map(|w| w.bone as usize).max().filter(|&b| b > 0) else {
        return DVec3::ZERO;
    };
    let axes = digits[(bone - 1) / 3].axes();
    let squares: f64 = row.iter().map(|w| w.weight * w.weight).sum();
    let outward = (x - axes.origin).reject_from(axes.axis).normalize_or_zero();
    1.5 * (1.0 - squares) * (1.0 - of_root).powi(2) * outward
}

/// Swelling of the thenar and hypothenar eminences along the normal, mm.
fn eminence(p: DVec3) -> f64 {
    let swell = |centre: DVec3, radii: DVec3, height: f64| {
        height * (-((p - centre) / radii).length_squared()).exp()
    };
    swell(
        DVec3::new(42.0, 28.0, -24.0),
        DVec3::new(24.0, 16.0, 14.0),
        2.2,
    ) + swell(
        DVec3::new(38.0, -26.0, -20.0),
        DVec3::new(26.0, 15.0, 14.0),
        2.6,
    )
}

/// Displacement of every vertex and every joint, mm a unit: `(skin[k], joints[k])`.
pub(super) fn shape_directions(
    digits: &[Digit; 5],
    joints: &[DVec3],
    skin: &Surface,
    weights: &Rows<SkinWeight>,
) -> (Vec<Vec<DVec3>>, Vec<Vec<DVec3>>) {
    let normals = skin.vertex_normals();
    let (mut vertices, mut moved): (Vec<Vec<DVec3>>, Vec<Vec<DVec3>>) = (0..COUNT)
        .map(|k| {
            let motions = motions(k, digits, joints);
            let vertices = skin
                .positions
                .iter()
                .zip(weights.iter())
                .zip(&normals)
                .map(|((&x, row), &n)| {
                    let swelling = match k {
                        7 => knuckle(digits, x, row),
                        9 => eminence(x) * n,
                        _ => DVec3::ZERO,
                    };
                    blended(&motions, row, x) + swelling
                })
                .collect();
            let moved = (0..16).map(|j| motions[j].at(joints[j])).collect();
            (vertices, moved)
        })
        .unzip();
    orthogonalise(&skin.vertex_areas(), &mut vertices, &mut moved);
    (vertices, moved)
}
