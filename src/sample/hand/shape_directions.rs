//! Ten directions in which hands differ, as smooth motions of skin and joints.
//!
//! Eight are affine maps of each bone, joined at the joints and blended by the skin weights; two swell
//! the skin: at the fingers' joints, and at the eminences of the palm. One unit is about one standard
//! deviation.

use super::anatomy::{Digit, parent};
use super::field::Axes;
use crate::math::Rows;
use crate::model::{SkinWeight, Surface};
use glam::{DMat3, DVec3};

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

/// x ↦ linear · x + offset: the displacement of one bone's surroundings.
#[derive(Clone, Copy)]
struct Motion {
    linear: DMat3,
    offset: DVec3,
}

impl Motion {
    fn at(&self, x: DVec3) -> DVec3 {
        self.linear * x + self.offset
    }
}

/// The motion of every bone in direction `k`; a child moves with its parent at their joint.
fn motions(k: usize, digits: &[Digit; 5], joints: &[DVec3]) -> Vec<Motion> {
    let mut all: Vec<Motion> = Vec::with_capacity(16);
    for bone in 0..16 {
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
        let [along, across, dorsal] = growth(k, bone);
        let frame = DMat3::from_cols(axes.axis, axes.lateral, axes.dorsal);
        let linear =
            frame * DMat3::from_diagonal(DVec3::new(along, across, dorsal)) * frame.transpose();
        let origin = match parent(bone) {
            Some(p) => all[p as usize].at(joints[bone]),
            None => DVec3::ZERO,
        };
        all.push(Motion {
            linear,
            offset: origin - linear * joints[bone],
        });
    }
    all
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
                    let blended: DVec3 = row
                        .iter()
                        .map(|w| w.weight * motions[w.bone as usize].at(x))
                        .sum();
                    let swelling = match k {
                        7 => knuckle(digits, x, row),
                        9 => eminence(x) * n,
                        _ => DVec3::ZERO,
                    };
                    blended + swelling
                })
                .collect();
            let moved = (0..16).map(|j| motions[j].at(joints[j])).collect();
            (vertices, moved)
        })
        .unzip();
    orthogonalise(&skin.vertex_areas(), &mut vertices, &mut moved);
    (vertices, moved)
}

/// Gram–Schmidt in the area-weighted product: orthogonal, as principal components are. Later
/// directions say what earlier ones do not; joints follow, since all is linear.
fn orthogonalise(areas: &[f64], vertices: &mut [Vec<DVec3>], joints: &mut [Vec<DVec3>]) {
    let product = |a: &[DVec3], b: &[DVec3]| -> f64 {
        let terms = a.iter().zip(b).zip(areas);
        terms.map(|((u, v), area)| area * u.dot(*v)).sum()
    };
    let subtract = |from: &mut [DVec3], what: &[DVec3], scale: f64| {
        from.iter_mut()
            .zip(what)
            .for_each(|(f, w)| *f -= scale * *w);
    };
    for k in 1..vertices.len() {
        for l in 0..k {
            let (before, rest) = vertices.split_at_mut(k);
            let scale = product(&rest[0], &before[l]) / product(&before[l], &before[l]);
            subtract(&mut rest[0], &before[l], scale);
            let (before, rest) = joints.split_at_mut(k);
            subtract(&mut rest[0], &before[l], scale);
        }
    }
}
