//! Leg and foot. Lengths in mm.

use super::outline::{Bulge, column};
use super::trunk::fork_edge;
use crate::field::{Axes, Section, Sweep, smooth_max, smooth_min, smoothstep};
use glam::DVec3;

/// The left leg as one implicit function.
#[derive(Clone, Debug)]
pub(super) struct Leg {
    shaft: Sweep,
    bulges: Vec<Bulge>,
    foot: Sweep,
    toes: Vec<Sweep>,
}

/// The foot's frame: from the heel forward and a little outward, dorsal up.
pub(super) fn foot_axes() -> Axes {
    Axes::new(
        DVec3::new(89.0, 0.0, -72.0),
        DVec3::new(0.10, 0.0, 1.0),
        DVec3::Y,
    )
}

/// Base and tip (station, lateral, height) and radius of each toe.
const TOES: [([f64; 3], [f64; 3], f64); 5] = [
    ([196.0, -27.0, 17.0], [250.0, -23.0, 12.0], 13.5),
    ([200.0, -7.0, 17.0], [252.0, -2.5, 10.0], 9.5),
    ([196.0, 9.0, 15.0], [245.0, 13.0, 9.5], 9.0),
    ([190.0, 23.0, 13.5], [234.0, 27.0, 9.0], 8.5),
    ([182.0, 36.0, 12.0], [220.0, 40.0, 8.5], 8.5),
];

impl Leg {
    pub fn new() -> Self {
        let axes = foot_axes();
        let section = |at: f64, u: f64, v: f64, extent: [f64; 3]| Section {
            at,
            centre: [u, v],
            extent,
        };
        let foot = Sweep::new(
            axes,
            vec![
                section(20.0, 0.0, 27.0, [27.0, 30.0, 31.0]),
                section(60.0, 0.0, 30.0, [29.0, 38.0, 34.0]),
                section(105.0, 0.0, 30.0, [34.0, 42.0, 32.0]),
                section(150.0, 2.0, 26.0, [42.0, 32.0, 28.0]),
                section(185.0, 4.0, 20.0, [47.0, 22.0, 23.0]),
                section(208.0, 4.0, 16.0, [44.0, 15.0, 18.0]),
            ],
            [20.0, 22.0],
        );
        let toes = TOES
            .into_iter()
            .map(|(base, tip, radius)| {
                let [base, tip] = [base, tip].map(|q| axes.world(q.into()));
                let line = Axes::new(base, tip - base, DVec3::Y);
                let length = base.distance(tip);
                let at = |s: f64, r: f64| section(s, 0.0, 0.0, [r, 0.92 * r, r]);
                Sweep::new(
                    line,
                    vec![
                        at(0.0, radius),
                        at(0.55 * length, 0.94 * radius),
                        at(0.85 * length, radius),
                    ],
                    [radius, radius],
                )
            })
            .collect();
        Self {
            shaft: column(
                &[
                    [960.0, 76.0, -4.0, 48.0, 52.0, 50.0],
                    [920.0, 82.0, -5.0, 66.0, 72.0, 68.0],
                    [880.0, 88.0, -6.0, 79.0, 81.0, 79.0],
                    [840.0, 92.0, -7.0, 81.0, 83.0, 82.0],
                    [790.0, 94.0, -8.0, 77.0, 82.0, 80.0],
                    [720.0, 94.0, -6.0, 74.0, 80.0, 73.0],
                    [640.0, 93.0, -3.0, 68.0, 74.0, 65.0],
                    [560.0, 92.0, 0.0, 58.0, 62.0, 56.0],
                    [500.0, 92.0, 0.0, 51.0, 54.0, 50.0],
                    [460.0, 92.0, -2.0, 49.0, 50.0, 49.0],
                    [420.0, 93.0, -6.0, 51.0, 46.0, 54.0],
                    [350.0, 94.0, -10.0, 54.0, 44.0, 62.0],
                    [280.0, 93.0, -12.0, 47.0, 42.0, 54.0],
                    [200.0, 92.0, -16.0, 34.0, 35.0, 38.0],
                    [130.0, 91.0, -20.0, 28.0, 31.0, 32.0],
                    [85.0, 90.0, -22.0, 30.0, 37.0, 33.0],
                    [50.0, 90.0, -24.0, 30.0, 40.0, 34.0],
                ],
                [40.0, 26.0],
            ),
            bulges: vec![
                // Kneecap, and the pad below it.
                Bulge::ball([92.0, 492.0, 36.0], [25.0, 28.0, 18.0], 24.0),
                Bulge::ball([92.0, 446.0, 31.0], [14.0, 22.0, 12.0], 22.0),
                // Inner and outer thigh above the knee.
                Bulge::ball([66.0, 560.0, 26.0], [24.0, 50.0, 28.0], 30.0),
                Bulge::ball([122.0, 600.0, 18.0], [22.0, 80.0, 30.0], 34.0),
                // The calf's two heads.
                Bulge::ball([72.0, 348.0, -38.0], [25.0, 72.0, 28.0], 24.0),
                Bulge::ball([114.0, 362.0, -36.0], [22.0, 66.0, 26.0], 24.0),
                // Ankle bones.
                Bulge::ball([64.0, 84.0, -18.0], [9.0, 13.0, 13.0], 12.0),
                Bulge::ball([117.0, 76.0, -26.0], [9.0, 13.0, 13.0], 12.0),
            ],
            foot,
            toes,
        }
    }

    /// The field at `p`; the foot stands on y = 0.
    pub fn distance(&self, p: DVec3) -> f64 {
        let mut leg = self.shaft.distance(p);
        for bulge in &self.bulges {
            leg = bulge.join(leg, p);
        }
        if p.y > 220.0 {
            return leg;
        }
        leg = smooth_min(leg, self.foot.distance(p), 36.0);
        let toes = self
            .toes
            .iter()
            .map(|t| t.distance(p))
            .reduce(|a, b| smooth_min(a, b, 2.5))
            .unwrap_or(f64::MAX);
        leg = smooth_min(leg, toes, 9.0);
        smooth_max(leg, -p.y, 8.0)
    }

    /// Edge length wanted at `p` on the leg.
    pub fn edge_length(&self, p: DVec3) -> f64 {
        let fall = |from: f64, to: f64, t: f64| from + (to - from) * smoothstep(t);
        let mut edge = fall(24.0, 18.0, 1.0 - (p.y - 485.0).abs() / 120.0);
        edge = fall(edge, 12.0, (220.0 - p.y) / 150.0);
        let along = foot_axes().local(p).x;
        if p.y < 120.0 {
            edge = fall(edge, 6.0, (along - 165.0) / 45.0);
        }
        edge.min(fork_edge(p))
    }
}
