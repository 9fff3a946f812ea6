//! Fine relief of the skin: flexion creases, the lines of the palm, nails. It is added
//! to the implicit function near its zero level, in mm; positive carves.

use super::anatomy::Digit;
use crate::field::{Sweep, smoothstep};
use glam::{DVec2, DVec3};

/// A groove across the palmar side of a digit.
#[derive(Clone, Copy, Debug)]
struct Crease {
    /// Station along the digit.
    at: f64,
    depth: f64,
    width: f64,
}

/// A nail: a rounded rectangle on the back of the last segment.
#[derive(Clone, Copy, Debug)]
struct Nail {
    centre: f64,
    half_length: f64,
    half_width: f64,
}

/// What is carved into one digit.
#[derive(Clone, Debug)]
struct DigitRelief {
    creases: Vec<Crease>,
    nail: Nail,
}

/// The relief of the whole hand.
#[derive(Clone, Debug)]
pub(super) struct Relief {
    digits: Vec<DigitRelief>,
}

/// Relief at a point, and the edge length (mm) that shows it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Detail {
    pub carve: f64,
    pub edge: f64,
}

/// Lines of the palm in the (x, y) plane with their depth: thenar, proximal and distal transverse
/// creases, two at the wrist.
const LINES: [(&[[f64; 2]], f64); 5] = [
    (
        &[
            [73.0, 37.0],
            [70.0, 25.0],
            [60.0, 13.5],
            [46.0, 7.0],
            [30.0, 5.0],
            [14.0, 8.0],
        ],
        1.0,
    ),
    (
        &[
            [74.5, 36.0],
            [73.0, 24.0],
            [67.0, 8.0],
            [58.0, -8.0],
            [50.0, -24.0],
        ],
        0.8,
    ),
    (
        &[
            [98.0, 15.0],
            [88.0, 9.0],
            [81.0, -4.0],
            [75.0, -20.0],
            [70.0, -40.0],
        ],
        0.9,
    ),
    (&[[2.0, 24.0], [4.5, 0.0], [2.0, -24.0]], 0.8),
    (&[[-5.0, 22.0], [-3.0, 0.0], [-5.0, -22.0]], 0.5),
];

fn bell(t: f64) -> f64 {
    (-t * t).exp()
}

/// 1 for |t| ≤ width, falling to 0 at 2.5 width.
fn plateau(t: f64, width: f64) -> f64 {
    1.0 - smoothstep((t.abs() / width - 1.0) / 1.5)
}

/// Distance to a polyline.
fn distance_to_line(p: DVec2, line: &[[f64; 2]]) -> f64 {
    line.windows(2)
        .map(|w| {
            let [a, b] = [w[0], w[1]].map(DVec2::from_array);
            let t = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            p.distance(a + t * (b - a))
        })
        .fold(f64::MAX, f64::min)
}

impl Relief {
    pub fn new(digits: &[Digit; 5]) -> Self {
        let digits = digits.iter().enumerate().map(|(d, digit)| {
            let joints = digit.local_joints().map(|j| j.x);
            let at = |segment: usize, fraction: f64| {
                joints[segment] + fraction * (joints[segment + 1] - joints[segment])
            };
            let crease = |at: f64, depth: f64, width: f64| Crease {
                at,
                depth: depth * digit.scale,
                width,
            };
            let mut creases = vec![
                // At the two far joints, and at a finger's root.
                crease(at(1, 0.0), 0.9, 1.5),
                crease(at(2, -0.05), 0.8, 1.4),
            ];
            if d < 4 {
                creases.push(crease(at(0, 0.44), 0.9, 1.6));
            }
            let length = joints[3] - joints[2];
            let wide = if d == 4 { 7.3 } else { 6.0 };
            DigitRelief {
                creases,
                nail: Nail {
                    centre: joints[2] + 0.68 * length,
                    half_length: 0.245 * length,
                    half_width: wide * digit.scale,
                },
            }
        });
        Self {
            digits: digits.collect(),
        }
    }

    /// Relief near digit `d`, whose field is `distance` at `p`.
    pub fn of_digit(&self, d: usize, sweep: &Sweep, distance: f64, p: DVec3) -> Detail {
        let near = 1.0 - smoothstep(distance.abs() / 4.0);
        let mut detail = Detail {
            carve: 0.0,
            edge: f64::MAX,
        };
        if near == 0.0 {
            return detail;
        }
        let local = sweep.axes.local(p);
        let [cu, cv, ..] = sweep.section(local.x);
        let (u, v) = (local.y - cu, local.z - cv);
        let up = v / u.hypot(v).max(1e-6);
        let relief = &self.digits[d];
        for crease in &relief.creases {
            // They reach round the sides.
            let facing = smoothstep((0.25 - up) / 0.6);
            let t = (local.x - crease.at) / crease.width;
            detail.carve += near * facing * crease.depth * bell(t);
            let edge = 1.9 + 2.2 * (1.0 - facing * plateau(t, 1.1));
            detail.edge = detail.edge.min(edge);
        }
        let nail = &relief.nail;
        // Signed distance to the rounded outline, in the plane of the nail.
        let corner = 0.55 * nail.half_width;
        let q = DVec2::new(
            (local.x - nail.centre).abs() - nail.half_length + corner,
            u.abs() - nail.half_width + corner,
        );
        let outline = q.max(DVec2::ZERO).length() + q.max_element().min(0.0) - corner;
        let facing = smoothstep((up - 0.1) / 0.3);
        // A fold around the plate, the plate slightly raised.
        let fold = 0.65 * bell((outline - 0.4) / 0.9);
        let plate = 0.35 * smoothstep(-outline / 1.2);
        detail.carve += near * facing * (fold - plate);
        if facing > 0.0 {
            detail.edge = detail
                .edge
                .min(1.3 + 2.5 * (1.0 - facing * plateau(outline, 1.7)));
        }
        detail
    }

    /// Relief of the palm.
    pub fn of_palm(&self, p: DVec3) -> Detail {
        let facing = smoothstep((-p.z - 3.0) / 5.0);
        let mut detail = Detail {
            carve: 0.0,
            edge: f64::MAX,
        };
        if facing == 0.0 {
            return detail;
        }
        for (line, depth) in LINES {
            let distance = distance_to_line(p.truncate(), line);
            let fine = if p.x < 8.0 { 3.5 } else { 2.2 };
            detail.carve += facing * depth * bell(distance / 1.5);
            detail.edge = detail
                .edge
                .min(fine + 3.0 * (1.0 - facing * plateau(distance, 1.8)));
        }
        detail
    }
}
