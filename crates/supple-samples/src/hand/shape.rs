//! The skin as one implicit function: palm, fingers and thumb, blended where flesh is continuous.

use super::anatomy::Digit;
use super::flesh;
use super::relief::{Detail, Relief};
use crate::field::{Ellipsoid, Sweep, smooth_max, smooth_min};
use crate::remesh::Implicit;
use glam::DVec3;

/// Where the forearm is cut.
const CUT: f64 = -30.0;
/// How far from the smooth surface relief reaches.
const RELIEF: f64 = 4.0;

/// The implicit hand.
#[derive(Clone, Debug)]
pub(crate) struct HandShape {
    wrist: Sweep,
    metacarpals: Vec<Sweep>,
    bulges: Vec<(Ellipsoid, f64)>,
    /// Index, middle, pinky, ring, thumb.
    pub digits: Vec<Sweep>,
    relief: Relief,
}

impl HandShape {
    pub fn new(digits: &[Digit; 5]) -> Self {
        Self {
            wrist: flesh::wrist(),
            metacarpals: digits[..4].iter().map(flesh::metacarpal).collect(),
            bulges: flesh::bulges(),
            digits: digits
                .iter()
                .enumerate()
                .map(|(d, digit)| flesh::digit(digit, d == 4))
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

    /// The skin without creases and nails.
    pub fn smooth_distance(&self, p: DVec3) -> f64 {
        self.without_relief(p, &self.digit_distances(p))
    }

    fn without_relief(&self, p: DVec3, digits: &[f64; 5]) -> f64 {
        let fingers = digits[1..4]
            .iter()
            .fold(digits[0], |a, &b| smooth_min(a, b, 3.0));
        let hand = smooth_min(self.palm(p), fingers, 7.0);
        let hand = smooth_min(hand, digits[4], 15.0);
        smooth_max(hand, CUT - p.x, 14.0)
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
    fn distance(&self, p: DVec3) -> f64 {
        let digits = self.digit_distances(p);
        let smooth = self.without_relief(p, &digits);
        let near = 1.0 - (smooth / RELIEF).powi(2);
        if near <= 0.0 {
            return smooth;
        }
        smooth + near * near * self.detail(p, &digits).carve
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
        let palm = 4.6;
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
