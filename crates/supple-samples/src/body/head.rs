//! Head and neck. Lengths in mm.

use super::outline::{Bulge, bell, column};
use crate::field::{Sweep, smooth_min, smoothstep};
use glam::DVec3;

/// Head and neck as one implicit function.
#[derive(Clone, Debug)]
pub(super) struct Head {
    neck: Sweep,
    face: Sweep,
    bulges: Vec<Bulge>,
    sockets: Bulge,
    lids: Bulge,
    nose: Vec<Bulge>,
    lips: Vec<Bulge>,
    ear: Bulge,
    concha: Bulge,
    cords: Vec<Bulge>,
}

/// Height of the line between the lips.
const MOUTH: f64 = 1541.0;

impl Head {
    pub fn new() -> Self {
        Self {
            neck: column(
                &[
                    [1585.0, 0.0, -6.0, 50.0, 40.0, 62.0],
                    [1540.0, 0.0, -8.0, 53.0, 48.0, 64.0],
                    [1500.0, 0.0, -14.0, 54.0, 53.0, 57.0],
                    [1470.0, 0.0, -21.0, 56.0, 54.0, 53.0],
                    [1440.0, 0.0, -28.0, 60.0, 55.0, 55.0],
                    [1400.0, 0.0, -34.0, 62.0, 50.0, 50.0],
                ],
                [20.0, 20.0],
            ),
            face: column(
                &[
                    [1660.0, 0.0, 20.0, 64.0, 74.0, 60.0],
                    [1630.0, 0.0, 20.0, 66.0, 73.0, 60.0],
                    [1600.0, 0.0, 20.0, 67.0, 70.0, 60.0],
                    [1572.0, 0.0, 20.0, 61.0, 75.0, 50.0],
                    [1545.0, 0.0, 18.0, 54.0, 78.0, 42.0],
                    [1520.0, 0.0, 18.0, 45.0, 74.0, 30.0],
                    [1506.0, 0.0, 20.0, 36.0, 69.0, 20.0],
                ],
                [40.0, 15.0],
            ),
            bulges: vec![
                // Cranium.
                Bulge::ball([0.0, 1640.0, 2.0], [75.0, 80.0, 95.0], 26.0),
                // Cheekbones.
                Bulge::ball([47.0, 1594.0, 58.0], [18.0, 15.0, 21.0], 24.0),
                // Cheeks.
                Bulge::ball([38.0, 1563.0, 54.0], [22.0, 26.0, 26.0], 30.0),
                // Corners of the jaw, and the jaw from there to the chin.
                Bulge::cord(
                    [
                        [45.0, 1556.0, 0.0],
                        [37.0, 1522.0, 42.0],
                        [14.0, 1508.0, 72.0],
                    ],
                    [12.0, 12.0, 12.0],
                    26.0,
                ),
                // Chin.
                Bulge::ball([0.0, 1508.0, 78.0], [20.0, 14.0, 17.0], 18.0),
                // Brow.
                Bulge::ball([26.0, 1633.0, 77.0], [26.0, 8.0, 14.0], 14.0),
            ],
            sockets: Bulge::ball([32.0, 1610.0, 101.0], [20.0, 11.0, 15.0], 11.0),
            lids: Bulge::ball([31.0, 1606.0, 74.0], [16.5, 13.5, 14.0], 5.0),
            nose: vec![
                Bulge::cord(
                    [
                        [0.0, 1620.0, 84.0],
                        [0.0, 1597.0, 95.0],
                        [0.0, 1576.0, 105.0],
                    ],
                    [8.0, 9.0, 11.5],
                    14.0,
                ),
                Bulge::ball([0.0, 1575.0, 106.5], [10.0, 10.0, 11.5], 8.0),
                Bulge::ball([12.0, 1571.0, 96.0], [8.0, 8.0, 11.0], 8.0),
            ],
            lips: vec![
                Bulge::cord(
                    [
                        [-28.0, 1541.0, 80.0],
                        [0.0, 1548.0, 97.0],
                        [28.0, 1541.0, 80.0],
                    ],
                    [4.5, 7.5, 4.5],
                    7.0,
                ),
                Bulge::cord(
                    [
                        [-26.0, 1540.0, 80.0],
                        [0.0, 1534.0, 95.5],
                        [26.0, 1540.0, 80.0],
                    ],
                    [4.5, 8.0, 4.5],
                    7.0,
                ),
            ],
            ear: Bulge::ellipsoid(
                [74.0, 1602.0, -8.0],
                DVec3::new(0.86, 0.0, 0.5),
                DVec3::new(-0.5, 0.2, 0.86),
                [6.5, 30.0, 18.0],
                5.0,
            ),
            concha: Bulge::ellipsoid(
                [77.5, 1602.0, -6.0],
                DVec3::new(0.86, 0.0, 0.5),
                DVec3::new(-0.5, 0.2, 0.86),
                [4.5, 19.0, 9.0],
                5.0,
            ),
            cords: vec![
                // Sternocleidomastoid.
                Bulge::cord(
                    [
                        [58.0, 1572.0, -18.0],
                        [42.0, 1505.0, 8.0],
                        [13.0, 1436.0, 24.0],
                    ],
                    [10.0, 11.0, 8.0],
                    14.0,
                ),
            ],
        }
    }

    /// The field at `p`, `p.x` ≥ 0.
    pub fn distance(&self, p: DVec3) -> f64 {
        let mut head = self.face.distance(p);
        for bulge in &self.bulges {
            head = bulge.join(head, p);
        }
        head = self.sockets.carve(head, p);
        head = self.lids.join(head, p);
        for part in self.nose.iter().chain(&self.lips) {
            head = part.join(head, p);
        }
        head += self.relief(p);
        head = self.concha.carve(self.ear.join(head, p), p);
        let mut neck = self.neck.distance(p);
        for cord in &self.cords {
            neck = cord.join(neck, p);
        }
        smooth_min(head, neck, 22.0)
    }

    /// The line between the lips, the furrow above them and the closed lids' seam; positive carves.
    fn relief(&self, p: DVec3) -> f64 {
        if p.z < 60.0 {
            return 0.0;
        }
        let ends = |half: f64| smoothstep((half - p.x) / 16.0);
        let mouth = 3.0 * bell((p.y - MOUTH) / 3.0) * ends(36.0);
        let philtrum = 0.8 * bell(p.x / 4.0) * bell((p.y - 1557.0) / 5.0);
        let lid = 1.2
            * bell((p.y - 1601.0 - 0.01 * (p.x - 31.0).powi(2)) / 2.0)
            * bell((p.x - 31.0) / 14.0).powi(2);
        mouth + philtrum + lid
    }

    /// Edge length wanted at `p` on the head.
    pub fn edge_length(&self, p: DVec3) -> f64 {
        let near = |d: f64, reach: f64| smoothstep(1.0 - d / reach);
        let finer = |edge: f64, fine: f64, share: f64| edge + (fine - edge) * share;
        let mut edge = 13.0;
        let facing = smoothstep((p.z - 30.0) / 40.0) * smoothstep((1665.0 - p.y) / 30.0);
        edge = finer(edge, 8.0, facing);
        let eye = p.distance(DVec3::new(31.0, 1606.0, 86.0));
        edge = finer(edge, 3.9, near(eye - 16.0, 14.0));
        let nose = p.distance(DVec3::new(6.0, 1574.0, 105.0));
        edge = finer(edge, 4.6, near(nose - 16.0, 14.0));
        let mouth = ((p - DVec3::new(0.0, 1541.0, 98.0)) / DVec3::new(2.2, 1.0, 2.0)).length();
        edge = finer(edge, 3.6, near(mouth - 13.0, 10.0));
        let ear = self.ear.distance(p).max(0.0);
        finer(edge, 4.8, near(ear, 14.0))
    }
}
