//! The trunk: pelvis, belly, chest, shoulder girdle, buttocks and breast. Lengths in mm.

use super::outline::{Bulge, bell, column};
use crate::field::{Sweep, smoothstep};
use glam::DVec3;

/// Edge length wanted near the fork of the legs.
pub(super) fn fork_edge(p: DVec3) -> f64 {
    let off = DVec3::new(p.x, 0.5 * (p.y - 825.0), 0.4 * p.z).length();
    12.0 + 12.0 * smoothstep((off - 14.0) / 40.0)
}

/// The trunk without neck, arms and legs.
#[derive(Clone, Debug)]
pub(super) struct Trunk {
    core: Sweep,
    /// One side; each meets its mirror image at the midline with a blend of its own.
    sides: Vec<(Bulge, f64)>,
}

/// Height of the navel.
const NAVEL: f64 = 1040.0;

impl Trunk {
    pub fn new() -> Self {
        Self {
            core: column(
                &[
                    [1455.0, 0.0, -34.0, 66.0, 46.0, 56.0],
                    [1425.0, 0.0, -30.0, 100.0, 62.0, 68.0],
                    [1395.0, 0.0, -27.0, 126.0, 75.0, 80.0],
                    [1350.0, 0.0, -22.0, 147.0, 92.0, 92.0],
                    [1300.0, 0.0, -16.0, 152.0, 108.0, 98.0],
                    [1250.0, 0.0, -12.0, 150.0, 116.0, 98.0],
                    [1200.0, 0.0, -10.0, 144.0, 114.0, 92.0],
                    [1140.0, 0.0, -8.0, 135.0, 107.0, 82.0],
                    [1085.0, 0.0, -4.0, 131.0, 103.0, 76.0],
                    [1040.0, 0.0, -2.0, 139.0, 104.0, 78.0],
                    [990.0, 0.0, -2.0, 152.0, 104.0, 86.0],
                    [940.0, 0.0, -4.0, 159.0, 98.0, 86.0],
                    [900.0, 0.0, -6.0, 150.0, 88.0, 78.0],
                    [865.0, 0.0, -6.0, 120.0, 72.0, 64.0],
                    [835.0, 0.0, -4.0, 78.0, 52.0, 48.0],
                ],
                [30.0, 20.0],
            ),
            sides: vec![
                // Pectoral with the breast's lower fullness, and its fold towards the arm.
                (
                    Bulge::ellipsoid(
                        [70.0, 1292.0, 58.0],
                        DVec3::new(0.95, 0.3, 0.0),
                        DVec3::new(0.25, 0.0, 0.97),
                        [76.0, 50.0, 36.0],
                        48.0,
                    ),
                    14.0,
                ),
                (
                    Bulge::ball([80.0, 1268.0, 68.0], [45.0, 41.0, 35.0], 38.0),
                    12.0,
                ),
                (
                    Bulge::cord(
                        [
                            [80.0, 1326.0, 52.0],
                            [130.0, 1352.0, 34.0],
                            [178.0, 1384.0, 8.0],
                        ],
                        [26.0, 28.0, 26.0],
                        36.0,
                    ),
                    14.0,
                ),
                // Latissimus: the back fold of the armpit.
                (
                    Bulge::cord(
                        [
                            [76.0, 1130.0, -24.0],
                            [118.0, 1262.0, -50.0],
                            [170.0, 1372.0, -42.0],
                        ],
                        [12.0, 32.0, 26.0],
                        50.0,
                    ),
                    30.0,
                ),
                // Shoulder blade.
                (
                    Bulge::ellipsoid(
                        [86.0, 1334.0, -80.0],
                        DVec3::new(0.3, 0.95, 0.0),
                        DVec3::NEG_Z,
                        [62.0, 42.0, 20.0],
                        58.0,
                    ),
                    20.0,
                ),
                // Trapezius: from the neck to the tip of the shoulder, and down the back.
                (
                    Bulge::cord(
                        [
                            [24.0, 1506.0, -46.0],
                            [84.0, 1448.0, -38.0],
                            [172.0, 1418.0, -28.0],
                        ],
                        [22.0, 25.0, 20.0],
                        48.0,
                    ),
                    20.0,
                ),
                // Collarbone.
                (
                    Bulge::cord(
                        [
                            [12.0, 1414.0, 22.0],
                            [80.0, 1421.0, 10.0],
                            [168.0, 1423.0, -17.0],
                        ],
                        [6.0, 7.0, 8.0],
                        24.0,
                    ),
                    8.0,
                ),
                // Buttock.
                (
                    Bulge::ellipsoid(
                        [74.0, 878.0, -62.0],
                        DVec3::new(0.9, 0.35, 0.0),
                        DVec3::new(0.2, 0.1, -1.0),
                        [76.0, 74.0, 60.0],
                        30.0,
                    ),
                    7.0,
                ),
                // Hip.
                (
                    Bulge::ball([114.0, 880.0, -14.0], [48.0, 96.0, 62.0], 50.0),
                    30.0,
                ),
                // Belly.
                (
                    Bulge::ball([0.0, 1010.0, 48.0], [92.0, 104.0, 54.0], 50.0),
                    30.0,
                ),
                // Mound over the pubic bone.
                (
                    Bulge::ball([0.0, 862.0, 38.0], [46.0, 44.0, 38.0], 34.0),
                    30.0,
                ),
                // Between the thighs.
                (
                    Bulge::ball([0.0, 842.0, 0.0], [34.0, 22.0, 56.0], 30.0),
                    30.0,
                ),
            ],
        }
    }

    /// The field at `p`, `p.x` ≥ 0.
    pub fn distance(&self, p: DVec3) -> f64 {
        let mut trunk = self.core.distance(p);
        for (bulge, midline) in &self.sides {
            trunk = bulge.join_pair(trunk, p, *midline);
        }
        trunk + self.relief(p)
    }

    /// The furrow of the spine, the line between the pectorals and down the belly, the navel.
    fn relief(&self, p: DVec3) -> f64 {
        let between =
            |low: f64, high: f64| smoothstep((p.y - low) / 50.0) * smoothstep((high - p.y) / 50.0);
        if p.z < -30.0 {
            4.0 * bell(p.x / 16.0) * between(930.0, 1420.0)
        } else if p.z > 30.0 {
            let sternum = 3.0 * bell(p.x / 14.0) * between(1170.0, 1420.0);
            let white_line = 1.5 * bell(p.x / 12.0) * between(1000.0, 1200.0);
            let navel = 7.0 * bell(p.x.hypot(p.y - NAVEL) / 8.0);
            sternum + white_line + navel
        } else {
            0.0
        }
    }

    /// Edge length wanted at `p` on the trunk.
    pub fn edge_length(&self, p: DVec3) -> f64 {
        let navel = p.distance(DVec3::new(0.0, NAVEL, 105.0));
        let edge = 24.0 + (6.5 - 24.0) * smoothstep(1.0 - (navel - 10.0) / 20.0);
        edge.min(fork_edge(p))
    }
}
