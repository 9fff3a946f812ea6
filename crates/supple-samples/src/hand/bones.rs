//! Closed bone surfaces: phalanges and metacarpals with heads thicker than shafts, a carpal block and
//! the ends of radius and ulna.

use super::anatomy::Digit;
use crate::field::{Axes, Section, Sweep};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};
use supple::model::Surface;

/// Half width and half height (mm, index finger) at (fraction of the bone's length).
type Outline = &'static [(f64, f64, f64)];

const METACARPAL: Outline = &[
    (0.0, 4.6, 5.4),
    (0.12, 4.5, 5.2),
    (0.45, 3.7, 4.0),
    (0.78, 4.6, 4.8),
    (0.92, 5.9, 6.2),
    (1.0, 5.4, 5.8),
];
const PROXIMAL: Outline = &[
    (0.0, 6.2, 5.2),
    (0.10, 6.3, 5.2),
    (0.5, 4.2, 3.6),
    (0.80, 4.5, 3.7),
    (0.93, 5.4, 4.4),
    (1.0, 5.0, 4.1),
];
const MIDDLE: Outline = &[
    (0.0, 5.4, 4.4),
    (0.12, 5.4, 4.3),
    (0.5, 3.7, 3.0),
    (0.78, 3.9, 3.1),
    (0.92, 4.7, 3.5),
    (1.0, 4.3, 3.3),
];
const DISTAL: Outline = &[
    (0.0, 4.7, 3.5),
    (0.15, 4.6, 3.3),
    (0.6, 2.7, 2.2),
    (0.88, 3.5, 2.0),
    (1.0, 3.0, 1.8),
];

/// Points around a section.
const AROUND: usize = 16;

/// The surface of an elliptical sweep: rings along it, round ends, poles.
fn lathe(sweep: &Sweep, caps: [f64; 2], rings: usize) -> Surface {
    let [first, last] = sweep.range();
    const CAP: usize = 4;
    // (station, displacement along the axis, scale of the section).
    let mut stations = Vec::new();
    for k in 1..CAP {
        let (sin, cos) = (FRAC_PI_2 * k as f64 / CAP as f64).sin_cos();
        stations.push((first, -caps[0] * cos, sin));
    }
    for k in 0..rings {
        let at = first + (last - first) * k as f64 / (rings - 1) as f64;
        stations.push((at, 0.0, 1.0));
    }
    for k in (1..CAP).rev() {
        let (sin, cos) = (FRAC_PI_2 * k as f64 / CAP as f64).sin_cos();
        stations.push((last, caps[1] * cos, sin));
    }
    let point = |s: f64, along: f64, u: f64, v: f64| {
        let [cu, cv, ..] = sweep.section(s);
        sweep.axes.world(DVec3::new(s + along, cu + u, cv + v))
    };
    let mut positions = vec![point(first, -caps[0], 0.0, 0.0)];
    for &(s, along, scale) in &stations {
        let [_, _, width, top, bottom] = sweep.section(s);
        for k in 0..AROUND {
            let (sin, cos) = (TAU * k as f64 / AROUND as f64).sin_cos();
            let height = if sin > 0.0 { top } else { bottom };
            positions.push(point(s, along, scale * width * cos, scale * height * sin));
        }
    }
    positions.push(point(last, caps[1], 0.0, 0.0));
    let vertex = |ring: usize, k: usize| (1 + ring * AROUND + k % AROUND) as u32;
    let end = positions.len() as u32 - 1;
    let mut triangles = Vec::new();
    for k in 0..AROUND {
        triangles.push([0, vertex(0, k + 1), vertex(0, k)]);
        for ring in 0..stations.len() - 1 {
            let [a, b] = [vertex(ring, k), vertex(ring, k + 1)];
            let [c, d] = [vertex(ring + 1, k), vertex(ring + 1, k + 1)];
            triangles.push([a, b, d]);
            triangles.push([a, d, c]);
        }
        triangles.push([
            vertex(stations.len() - 1, k),
            vertex(stations.len() - 1, k + 1),
            end,
        ]);
    }
    Surface {
        positions,
        triangles,
    }
}

/// A long bone between two joint centres, `gaps` short of them, raised dorsally by `raise`.
fn long_bone(
    ends: [DVec3; 2],
    gaps: [f64; 2],
    dorsal: DVec3,
    outline: Outline,
    scale: f64,
    raise: f64,
) -> Surface {
    let axes = Axes::new(ends[0], ends[1] - ends[0], dorsal);
    let caps = [2.4, 3.2].map(|c| c * scale);
    let from = gaps[0] + caps[0];
    let length = ends[0].distance(ends[1]) - gaps[1] - caps[1] - from;
    let sections = outline
        .iter()
        .map(|&(fraction, width, height)| Section {
            at: from + fraction * length,
            centre: [0.0, raise],
            extent: [width * scale, height * scale, height * scale],
        })
        .collect();
    lathe(&Sweep::new(axes, sections, caps), caps, 18)
}

/// A block along +x: rows of (station, centre y, centre z, half width, half height).
fn block(rows: &[(f64, f64, f64, f64, f64)], caps: [f64; 2]) -> Surface {
    let axes = Axes::new(DVec3::ZERO, DVec3::X, DVec3::Z);
    let sections = rows
        .iter()
        .map(|&(at, y, z, width, height)| Section {
            at,
            centre: [y, z],
            extent: [width, height, height],
        })
        .collect();
    lathe(&Sweep::new(axes, sections, caps), caps, 10)
}

/// Appends a component.
fn append(surface: &mut Surface, part: Surface) {
    let offset = surface.positions.len() as u32;
    surface.positions.extend(part.positions);
    surface
        .triangles
        .extend(part.triangles.iter().map(|t| t.map(|v| v + offset)));
}

/// One surface a bone, in the skeleton's order, mm. The wrist bone has seven parts: radius, ulna,
/// carpus, four metacarpals.
pub(super) fn bones(digits: &[Digit; 5]) -> Vec<Surface> {
    let mut root = Surface::default();
    append(
        &mut root,
        block(
            &[
                (-23.0, 8.5, 0.0, 9.0, 7.5),
                (-14.0, 8.5, -0.5, 11.5, 8.0),
                (-6.5, 9.0, -0.5, 13.0, 8.5),
            ],
            [2.5, 3.0],
        ),
    );
    append(
        &mut root,
        block(
            &[
                (-23.0, -14.0, 1.0, 6.0, 6.0),
                (-14.0, -14.5, 1.0, 6.0, 6.0),
                (-6.5, -14.5, 1.0, 7.0, 6.5),
            ],
            [2.5, 3.0],
        ),
    );
    append(
        &mut root,
        block(
            &[
                (1.5, 0.0, -0.5, 18.0, 7.5),
                (8.0, 0.0, -0.5, 20.0, 8.5),
                (16.0, 0.0, 0.0, 20.0, 8.0),
            ],
            [3.0, 4.0],
        ),
    );
    for digit in &digits[..4] {
        let ends = [digit.base, digit.joints[0]];
        let bone = long_bone(ends, [0.0, -1.0], digit.dorsal, METACARPAL, 1.0, 1.5);
        append(&mut root, bone);
    }
    let mut all = vec![root];
    for (d, digit) in digits.iter().enumerate() {
        let is_thumb = d == 4;
        let outlines = if is_thumb {
            [METACARPAL, PROXIMAL, DISTAL]
        } else {
            [PROXIMAL, MIDDLE, DISTAL]
        };
        for (k, outline) in outlines.into_iter().enumerate() {
            let ends = [digit.joints[k], digit.joints[k + 1]];
            // A joint's cavity; the distal phalanx leaves room for the pulp.
            let first = if k == 0 && !is_thumb { 5.5 } else { 2.0 };
            let gaps = [first, if k == 2 { 5.0 * digit.scale } else { -1.2 }];
            let scale = digit.scale * if is_thumb && k > 0 { 1.1 } else { 1.0 };
            let raise = [0.3, 0.5, 0.6][k];
            all.push(long_bone(ends, gaps, digit.dorsal, outline, scale, raise));
        }
    }
    all
}
