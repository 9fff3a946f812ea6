//! Skin weights: each vertex starts with the bone of its own digit's segment, and heat blends them.

use super::anatomy::Digit;
use super::shape::HandShape;
use crate::heat_weights::heat_weights;
use glam::DVec3;
use supple::Result;
use supple::internal::math::Rows;
use supple::model::{SkinWeight, Surface};

/// Where a point lies: digit (if any), bone, and the radius of the blend there (mm).
fn segment(shape: &HandShape, stations: &[[f64; 4]], p: DVec3) -> (usize, f64) {
    let (digit, distance) = shape.nearest_digit(p);
    let sweep = &shape.digits[digit];
    let s = sweep.axes.local(p).x;
    let joints = &stations[digit];
    // The palm belongs to the wrist; the thumb's metacarpal lies in it and takes what is near.
    let own = s > joints[0] && (digit < 4 || distance < shape.palm(p) + 5.0);
    if !own {
        return (0, if digit == 4 { 6.0 } else { 4.5 });
    }
    let k = joints[..3].iter().filter(|&&j| s > j).count() - 1;
    // Wide at the root of the digit, narrow at its far joints.
    let reach = ((s - joints[0]) / (joints[1] - joints[0])).clamp(0.0, 1.0);
    let wide = if digit == 4 { 6.0 } else { 4.5 };
    (1 + 3 * digit + k, wide + (2.6 - wide) * reach)
}

/// At most four bones for each vertex, with Σ w = 1.
pub(super) fn weights(
    shape: &HandShape,
    digits: &[Digit; 5],
    skin: &Surface,
) -> Result<Rows<SkinWeight>> {
    let stations: Vec<[f64; 4]> = digits
        .iter()
        .map(|d| d.local_joints().map(|j| j.x))
        .collect();
    let (bone, radius): (Vec<usize>, Vec<f64>) = skin
        .positions
        .iter()
        .map(|&p| segment(shape, &stations, p))
        .unzip();
    heat_weights(skin, 16, &bone, &radius)
}
