//! Arm and hand. Lengths in mm.

use super::anatomy;
use super::outline::Bulge;
use crate::field::{Axes, Section, Sweep, smooth_min, smoothstep};
use crate::hand::HandShape;
use glam::DVec3;

/// The left arm as one implicit function; its hand is the sample hand without creases, mirrored.
#[derive(Clone, Debug)]
pub(super) struct Arm {
    axes: Axes,
    shaft: Sweep,
    bulges: Vec<Bulge>,
    hand: HandShape,
    wrist: f64,
}

/// Sections along the arm: station, centre (back, up), half width back and forth, height above the
/// centre, depth below it.
const SECTIONS: [[f64; 6]; 12] = [
    [-40.0, 4.0, -4.0, 44.0, 36.0, 40.0],
    [0.0, 3.0, -4.0, 49.0, 42.0, 46.0],
    [45.0, 2.0, -4.0, 49.0, 42.0, 47.0],
    [100.0, 2.0, -3.0, 45.0, 39.0, 44.0],
    [165.0, 0.0, -1.0, 43.0, 38.0, 41.0],
    [225.0, 0.0, 0.0, 40.0, 35.0, 36.0],
    [268.0, 0.0, 0.0, 40.0, 34.0, 34.0],
    [310.0, -1.0, 0.0, 43.0, 35.0, 35.0],
    [360.0, -1.0, 0.0, 41.0, 34.0, 34.0],
    [430.0, 0.0, 0.0, 33.5, 28.0, 28.0],
    [490.0, 0.0, 0.0, 28.0, 21.0, 21.0],
    [520.0, 0.0, -1.0, 27.5, 17.0, 18.0],
];

/// The sample hand is that of a person of 1.76 m.
const HAND_SCALE: f64 = 0.975;

impl Arm {
    pub fn new() -> Self {
        let axes = anatomy::arm();
        let sections = SECTIONS
            .iter()
            .map(|&[at, u, v, width, top, bottom]| Section {
                at,
                centre: [u, v],
                extent: [width, top, bottom],
            })
            .collect();
        let local = |q: [f64; 3]| axes.world(DVec3::from_array(q)).to_array();
        let ball = |q: [f64; 3], radii: [f64; 3], blend: f64| {
            Bulge::ellipsoid(local(q), axes.axis, axes.dorsal, radii, blend)
        };
        Self {
            shaft: Sweep::new(axes, sections, [30.0, 12.0]),
            bulges: vec![
                // Deltoid: over the shoulder, in front of it and behind it.
                ball([28.0, 2.0, 14.0], [62.0, 44.0, 30.0], 36.0),
                ball([18.0, -26.0, -2.0], [54.0, 26.0, 36.0], 30.0),
                ball([18.0, 30.0, -2.0], [54.0, 24.0, 36.0], 30.0),
                // Biceps in front, triceps behind and below.
                ball([150.0, -20.0, 2.0], [72.0, 24.0, 30.0], 26.0),
                ball([135.0, 20.0, -14.0], [80.0, 26.0, 30.0], 28.0),
                // Point of the elbow, and the forearm's extensors.
                ball([266.0, 26.0, -4.0], [18.0, 14.0, 14.0], 16.0),
                ball([325.0, -14.0, 12.0], [58.0, 26.0, 24.0], 24.0),
                ball([330.0, 12.0, -10.0], [62.0, 26.0, 26.0], 24.0),
            ],
            hand: HandShape::new(&crate::hand::digits()),
            wrist: anatomy::arm_stations()[1],
            axes,
        }
    }

    /// Coordinates in the sample hand: a right hand, thumb side +y, back of the hand +z.
    fn in_hand(&self, p: DVec3) -> DVec3 {
        let local = self.axes.local(p);
        DVec3::new(local.x - self.wrist, -local.y, local.z) / HAND_SCALE
    }

    /// Whether `p` lies on the thumb.
    pub fn is_thumb(&self, p: DVec3) -> bool {
        self.hand.nearest_digit(self.in_hand(p)).0 == 4
    }

    /// The field at `p`.
    pub fn distance(&self, p: DVec3) -> f64 {
        let station = self.axes.local(p).x;
        let mut arm = f64::MAX;
        if station < self.wrist + 60.0 {
            arm = self.shaft.distance(p);
            for bulge in &self.bulges {
                arm = bulge.join(arm, p);
            }
        }
        if station > self.wrist - 90.0 {
            let hand = HAND_SCALE * self.hand.smooth_distance(self.in_hand(p));
            arm = if arm == f64::MAX {
                hand
            } else {
                smooth_min(arm, hand, 14.0)
            };
        }
        arm
    }

    /// Edge length wanted at `p` on the arm.
    pub fn edge_length(&self, p: DVec3) -> f64 {
        let station = self.axes.local(p).x;
        let fall = |from: f64, to: f64, t: f64| from + (to - from) * smoothstep(t);
        let edge = fall(22.0, 16.0, 1.0 - (station - 268.0).abs() / 110.0);
        let edge = fall(edge, 9.5, (station - self.wrist + 110.0) / 100.0);
        if station < self.wrist + 20.0 {
            return edge;
        }
        let (_, distance) = self.hand.nearest_digit(self.in_hand(p));
        fall(edge, 6.0, 1.0 - distance / 14.0)
    }
}
