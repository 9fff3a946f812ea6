//! Outlines of the parts of the hand: widths, heights and depths of digits, palm and wrist, mm.

use super::anatomy::Digit;
use crate::field::{Axes, Ellipsoid, Section, Sweep};
use glam::DVec3;

/// Rows of a digit's profile: (segment, fraction of it, half width, height, depth).
type Profile = &'static [(usize, f64, f64, f64, f64)];

/// The index finger's; segment 0 runs from the MCP joint to the PIP joint.
const FINGER: Profile = &[
    (0, -0.30, 8.2, 7.0, 8.5),
    (0, 0.05, 9.8, 8.6, 10.2),
    (0, 0.40, 10.0, 8.6, 10.8),
    (0, 0.70, 9.5, 8.2, 10.4),
    (1, 0.00, 9.9, 9.0, 9.2),
    (1, 0.50, 8.8, 7.7, 9.6),
    (2, 0.00, 8.8, 7.6, 8.2),
    (2, 0.38, 8.5, 6.8, 8.9),
    (2, 0.64, 7.7, 6.0, 7.8),
];

/// The thumb's, over 1.12; segment 0 is the metacarpal.
const THUMB: Profile = &[
    (0, 0.00, 11.5, 9.0, 12.5),
    (0, 0.45, 12.0, 9.0, 15.0),
    (0, 0.80, 10.8, 9.3, 13.5),
    (1, 0.00, 10.6, 9.8, 11.3),
    (1, 0.50, 9.4, 8.2, 10.0),
    (2, 0.00, 10.0, 8.5, 8.8),
    (2, 0.36, 10.0, 7.2, 9.6),
    (2, 0.68, 8.6, 6.2, 8.0),
];

/// A finger or the thumb, from inside the palm to the tip.
pub(super) fn digit(digit: &Digit, is_thumb: bool) -> Sweep {
    let profile = if is_thumb { THUMB } else { FINGER };
    let joints = digit.local_joints();
    let sections: Vec<Section> = profile
        .iter()
        .map(|&(segment, fraction, width, height, depth)| {
            let centre = joints[segment].lerp(joints[segment + 1], fraction);
            Section {
                at: centre.x,
                centre: [centre.y, centre.z],
                extent: [width, height, depth].map(|e| e * digit.scale),
            }
        })
        .collect();
    let tip = joints[3].x - sections[sections.len() - 1].at;
    Sweep::new(digit.axes(), sections, [8.0, tip])
}

/// A ray of the palm around a finger's metacarpal.
pub(super) fn metacarpal(digit: &Digit) -> Sweep {
    let axes = Axes::new(digit.base, digit.joints[0] - digit.base, digit.dorsal);
    let length = axes.local(digit.joints[0]).x;
    let section = |fraction: f64, width: f64, height: f64, depth: f64| Section {
        at: fraction * length,
        centre: [0.0, 0.0],
        extent: [width * digit.scale, height, depth],
    };
    let sections = vec![
        section(0.0, 9.0, 10.5, 14.0),
        section(0.35, 10.5, 9.8, 12.5),
        section(0.7, 11.0, 9.8, 12.5),
        section(0.96, 10.6, 10.8, 14.5),
        section(1.10, 9.5, 8.6, 13.0),
    ];
    Sweep::new(axes, sections, [8.0, 9.0])
}

/// Wrist and the beginning of the forearm.
pub(super) fn wrist() -> Sweep {
    let axes = Axes::new(DVec3::ZERO, DVec3::X, DVec3::Z);
    let section = |at: f64, centre: f64, width: f64, height: f64, depth: f64| Section {
        at,
        centre: [centre, 0.0],
        extent: [width, height, depth],
    };
    Sweep::new(
        axes,
        vec![
            section(-45.0, 0.0, 28.5, 17.5, 20.0),
            section(-15.0, 0.0, 28.0, 16.5, 18.5),
            section(0.0, 0.0, 28.0, 15.5, 17.5),
            section(14.0, 0.5, 29.0, 14.5, 17.0),
            section(32.0, 2.0, 29.0, 12.5, 15.0),
        ],
        [10.0, 16.0],
    )
}

/// What swells or fills the palm, each with its blend radius.
pub(super) fn bulges() -> Vec<(Ellipsoid, f64)> {
    let ellipsoid =
        |centre: [f64; 3], along: [f64; 3], dorsal: [f64; 3], radii: [f64; 3]| Ellipsoid {
            axes: Axes::new(
                DVec3::from_array(centre),
                DVec3::from_array(along),
                DVec3::from_array(dorsal),
            ),
            radii: DVec3::from_array(radii),
        };
    vec![
        // Thenar eminence, along the thumb's metacarpal.
        (
            ellipsoid(
                [40.0, 27.0, -13.0],
                [0.80, 0.55, -0.15],
                [0.0, 0.3, 1.0],
                [29.0, 14.0, 13.0],
            ),
            10.0,
        ),
        // Hypothenar eminence, along the little finger's metacarpal.
        (
            ellipsoid(
                [38.0, -24.0, -9.0],
                [0.93, -0.22, 0.0],
                [0.0, -0.2, 1.0],
                [34.0, 13.5, 13.0],
            ),
            10.0,
        ),
        // First web, between the thumb and the index finger.
        (
            ellipsoid(
                [55.0, 34.0, -6.0],
                [0.80, 0.45, -0.1],
                [0.1, -0.2, 1.0],
                [17.0, 13.0, 6.5],
            ),
            14.0,
        ),
        // Its edge at the index finger's root.
        (
            ellipsoid(
                [73.0, 34.0, -5.0],
                [1.0, 0.1, 0.0],
                [0.0, -0.2, 1.0],
                [13.0, 6.5, 5.5],
            ),
            10.0,
        ),
        // The hollow's floor.
        (
            ellipsoid(
                [60.0, -4.0, -4.0],
                [1.0, -0.1, 0.0],
                [0.0, 0.0, 1.0],
                [30.0, 25.0, 8.0],
            ),
            8.0,
        ),
        // Head of the ulna.
        (
            ellipsoid(
                [-9.0, -19.0, 9.0],
                [1.0, 0.0, 0.0],
                [0.0, 0.0, 1.0],
                [10.0, 7.5, 7.5],
            ),
            6.0,
        ),
        // Fat pads below the finger roots.
        (
            ellipsoid(
                [97.0, 15.0, -7.0],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 1.0],
                [20.0, 11.0, 6.5],
            ),
            6.0,
        ),
        (
            ellipsoid(
                [92.0, -18.0, -8.0],
                [-0.35, 1.0, 0.1],
                [0.0, 0.0, 1.0],
                [20.0, 11.0, 6.5],
            ),
            6.0,
        ),
    ]
}
