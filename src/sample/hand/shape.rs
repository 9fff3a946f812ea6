//! The skin as one implicit function: palm, fingers and thumb, blended where flesh is continuous.

use super::anatomy::Digit;
use super::field::{Axes, Ellipsoid, Section, Sweep, smooth_max, smooth_min};
use super::relief::{Detail, Relief};
use super::remesh::Implicit;
use glam::DVec3;

/// Where the forearm is cut.
const CUT: f64 = -30.0;
/// How far from the smooth surface relief reaches.
const RELIEF: f64 = 4.0;

/// The implicit hand.
#[derive(Clone, Debug)]
pub(super) struct HandShape {
    wrist: Sweep,
    metacarpals: Vec<Sweep>,
    bulges: Vec<(Ellipsoid, f64)>,
    /// Index, middle, pinky, ring, thumb.
    pub digits: Vec<Sweep>,
    relief: Relief,
}

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

fn digit_sweep(digit: &Digit, profile: Profile) -> Sweep {
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

fn metacarpal(digit: &Digit) -> Sweep {
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

fn wrist() -> Sweep {
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

fn bulges() -> Vec<(Ellipsoid, f64)> {
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

impl HandShape {
    pub fn new(digits: &[Digit; 5]) -> Self {
        Self {
            wrist: wrist(),
            metacarpals: digits[..4].iter().map(metacarpal).collect(),
            bulges: bulges(),
            digits: digits
                .iter()
                .enumerate()
                .map(|(d, digit)| digit_sweep(digit, if d == 4 { THUMB } else { FINGER }))
                .collect(),
            relief: Relief::new(digits),
        }
    }

    /// The field of every digit.
    fn digit_distances(&self, p: DVec3) -> [f64; 5] {
        std::array::from_fn(|d| self.digits[d].distance(p))
    }

    /// The digit whose field is smallest at `p`, with its value.
    pub fn nearest_digit(&self, p: DVec3) -> (usize, f64) {
        nearest(&self.digit_distances(p))
    }

    /// The palm and the wrist, without fingers and thumb.
    pub fn palm(&self, p: DVec3) -> f64 {
        let rays = self
            .metacarpals
            .iter()
            .map(|m| m.distance(p))
            .reduce(|a, b| smooth_min(a, b, 9.0))
            .unwrap_or(f64::MAX);
        let mut palm = smooth_min(rays, self.wrist.distance(p), 12.0);
        for (bulge, k) in &self.bulges {
            palm = smooth_min(palm, bulge.distance(p), *k);
        }
        palm
    }

    /// The whole skin: negative inside, about the distance (mm) near it.
    pub fn distance(&self, p: DVec3) -> f64 {
        let digits = self.digit_distances(p);
        let fingers = digits[1..4]
            .iter()
            .fold(digits[0], |a, &b| smooth_min(a, b, 3.0));
        let hand = smooth_min(self.palm(p), fingers, 7.0);
        let hand = smooth_min(hand, digits[4], 15.0);
        let smooth = smooth_max(hand, CUT - p.x, 14.0);
        let near = 1.0 - (smooth / RELIEF).powi(2);
        if near <= 0.0 {
            return smooth;
        }
        smooth + near * near * self.detail(p, &digits).carve
    }

    /// Relief at `p`, and the edge length that it asks for.
    fn detail(&self, p: DVec3, digits: &[f64; 5]) -> Detail {
        let (digit, distance) = nearest(digits);
        let of_digit = self
            .relief
            .of_digit(digit, &self.digits[digit], distance, p);
        let of_palm = self.relief.of_palm(p);
        // Lines of the palm end where a digit begins.
        let clear = (distance / 3.0).clamp(0.0, 1.0);
        Detail {
            carve: of_digit.carve + clear * of_palm.carve,
            edge: of_digit.edge.min(of_palm.edge + 3.0 * (1.0 - clear)),
        }
    }
}

impl Implicit for HandShape {
    /// `p` moved onto the zero level by Newton steps along the gradient.
    fn project(&self, mut p: DVec3) -> DVec3 {
        for _ in 0..4 {
            let value = self.distance(p);
            let h = 1e-4;
            let slope = DVec3::AXES.map(|e| (self.distance(p + h * e) - value) / h);
            let slope = DVec3::from_array(slope);
            if value.abs() < 1e-5 || slope.length_squared() < 1e-6 {
                break;
            }
            p -= (value / slope.length_squared() * slope).clamp_length_max(3.0);
        }
        p
    }
    fn edge_length(&self, p: DVec3) -> f64 {
        let digits = self.digit_distances(p);
        let (digit, distance) = nearest(&digits);
        let sweep = &self.digits[digit];
        let [_, tip] = sweep.range();
        // Finer on digits, and finer still towards their tips; the wrist needs little.
        let along = (sweep.axes.local(p).x / tip).clamp(0.0, 1.0);
        let on_digit = (1.0 - distance / 10.0).clamp(0.0, 1.0);
        let fine = 3.2 - 0.4 * along;
        let palm = 4.6 + 0.7 * (-p.x / 12.0).clamp(0.0, 1.0);
        (palm + (fine - palm) * on_digit).min(self.detail(p, &digits).edge)
    }
}

/// The smallest of the digits' fields.
fn nearest(distances: &[f64; 5]) -> (usize, f64) {
    let mut best = (0, distances[0]);
    for (d, &distance) in distances.iter().enumerate() {
        if distance < best.1 {
            best = (d, distance);
        }
    }
    best
}
