//! Implicit primitives: swept sections, ellipsoids and their smooth union. Lengths in mm; a field is
//! negative inside and close to the distance near its zero level.

use glam::DVec3;

/// 0 for t ≤ 0, 1 for t ≥ 1, 3t² − 2t³ in between.
pub(super) fn smoothstep(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Quadratic smooth minimum: equals min(a, b) where |a − b| ≥ k (Quilez, "smooth minimum").
pub(super) fn smooth_min(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - 0.25 * h * h * k
}

/// The counterpart of [`smooth_min`] for intersections.
pub(super) fn smooth_max(a: f64, b: f64, k: f64) -> f64 {
    -smooth_min(-a, -b, k)
}

/// First-order distance to {q : |q| = 1} where q = coordinates over semi-axes:
/// (|q| − 1) |q| / |q / semi-axes|.
fn ellipsoid_distance(offset: DVec3, axes: DVec3) -> f64 {
    let q = offset / axes;
    let (k0, k1) = (q.length(), (q / axes).length());
    if k1 < 1e-9 {
        return -axes.min_element();
    }
    k0 * (k0 - 1.0) / k1
}

/// A right-handed frame: distal axis, lateral (towards the thumb side), dorsal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axes {
    pub origin: DVec3,
    pub axis: DVec3,
    pub lateral: DVec3,
    pub dorsal: DVec3,
}

impl Axes {
    /// From a distal direction and an approximate dorsal one.
    pub fn new(origin: DVec3, axis: DVec3, dorsal: DVec3) -> Self {
        let axis = axis.normalize();
        let dorsal = dorsal.reject_from(axis).normalize();
        Self {
            origin,
            axis,
            lateral: dorsal.cross(axis),
            dorsal,
        }
    }

    /// Coordinates (along, lateral, dorsal) of `p`.
    pub fn local(&self, p: DVec3) -> DVec3 {
        let d = p - self.origin;
        DVec3::new(d.dot(self.axis), d.dot(self.lateral), d.dot(self.dorsal))
    }

    /// The point at coordinates `q`.
    pub fn world(&self, q: DVec3) -> DVec3 {
        self.origin + self.axis * q.x + self.lateral * q.y + self.dorsal * q.z
    }
}

/// One section of a sweep: where, centre offset, and half extents of its egg-shaped outline.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    /// Along the axis.
    pub at: f64,
    /// Centre, lateral and dorsal.
    pub centre: [f64; 2],
    /// Half width, height above the centre, depth below it.
    pub extent: [f64; 3],
}

/// Sections along an axis, joined by cubic Hermite interpolation, with half-ellipsoid ends.
#[derive(Clone, Debug)]
pub(super) struct Sweep {
    pub axes: Axes,
    sections: Vec<Section>,
    slopes: Vec<[f64; 5]>,
    /// Lengths of the proximal and distal caps.
    caps: [f64; 2],
}

fn columns(s: &Section) -> [f64; 5] {
    [
        s.centre[0],
        s.centre[1],
        s.extent[0],
        s.extent[1],
        s.extent[2],
    ]
}

impl Sweep {
    pub fn new(axes: Axes, sections: Vec<Section>, caps: [f64; 2]) -> Self {
        let last = sections.len() - 1;
        let secant = |i: usize, k: usize| {
            let (a, b) = (&sections[i], &sections[i + 1]);
            (columns(b)[k] - columns(a)[k]) / (b.at - a.at)
        };
        // Catmull–Rom slopes inside, flat extents at the ends so that the caps join smoothly.
        let slopes = (0..=last)
            .map(|i| {
                std::array::from_fn(|k| {
                    if i == 0 || i == last {
                        if k < 2 {
                            secant(if i == 0 { 0 } else { last - 1 }, k)
                        } else {
                            0.0
                        }
                    } else {
                        0.5 * (secant(i - 1, k) + secant(i, k))
                    }
                })
            })
            .collect();
        Self {
            axes,
            sections,
            slopes,
            caps,
        }
    }

    /// First and last station.
    pub fn range(&self) -> [f64; 2] {
        [
            self.sections[0].at,
            self.sections[self.sections.len() - 1].at,
        ]
    }

    /// (centre lateral, centre dorsal, half width, height, depth) at station `s`.
    pub fn section(&self, s: f64) -> [f64; 5] {
        let [first, last] = self.range();
        let s = s.clamp(first, last);
        let i = self.sections[1..self.sections.len() - 1]
            .iter()
            .take_while(|x| x.at <= s)
            .count();
        let (a, b) = (&self.sections[i], &self.sections[i + 1]);
        let length = b.at - a.at;
        let t = (s - a.at) / length;
        let (t2, t3) = (t * t, t * t * t);
        let (p, q) = (columns(a), columns(b));
        std::array::from_fn(|k| {
            p[k] * (2.0 * t3 - 3.0 * t2 + 1.0)
                + q[k] * (3.0 * t2 - 2.0 * t3)
                + length
                    * (self.slopes[i][k] * (t3 - 2.0 * t2 + t) + self.slopes[i + 1][k] * (t3 - t2))
        })
    }

    /// The field at `p`.
    pub fn distance(&self, p: DVec3) -> f64 {
        let local = self.axes.local(p);
        let [first, last] = self.range();
        let beyond = local.x - local.x.clamp(first, last);
        let [cu, cv, width, top, bottom] = self.section(local.x);
        let (u, v) = (local.y - cu, local.z - cv);
        let height = if v > 0.0 { top } else { bottom };
        let cap = if beyond < 0.0 {
            self.caps[0]
        } else {
            self.caps[1]
        };
        ellipsoid_distance(DVec3::new(beyond, u, v), DVec3::new(cap, width, height))
    }
}

/// An ellipsoid.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ellipsoid {
    pub axes: Axes,
    pub radii: DVec3,
}

impl Ellipsoid {
    /// The field at `p`.
    pub fn distance(&self, p: DVec3) -> f64 {
        ellipsoid_distance(self.axes.local(p), self.radii)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use supple::internal::math::Random;

    #[test]
    fn smooth_minimum_is_the_minimum_apart_and_below_it_near() {
        assert_eq!(smooth_min(1.0, 4.0, 3.0), 1.0);
        assert_eq!(smooth_max(1.0, 4.0, 3.0), 4.0);
        assert_relative_eq!(smooth_min(2.0, 2.0, 4.0), 1.0);
        for a in [-1.0, 0.3, 2.0] {
            assert!(smooth_min(a, 0.5, 3.0) < a.min(0.5));
            assert_eq!(smooth_min(a, 0.5, 3.0), smooth_min(0.5, a, 3.0));
        }
    }

    fn cigar() -> Sweep {
        let section = |at: f64, radius: f64| Section {
            at,
            centre: [0.0, 0.0],
            extent: [radius; 3],
        };
        let axes = Axes::new(DVec3::X, DVec3::new(1.0, 2.0, 2.0), DVec3::Z);
        Sweep::new(
            axes,
            vec![section(0.0, 2.0), section(5.0, 2.0), section(9.0, 2.0)],
            [2.0, 2.0],
        )
    }

    #[test]
    fn an_even_sweep_is_a_capsule() {
        let sweep = cigar();
        let random = &mut Random::new(7);
        for _ in 0..200 {
            let local = DVec3::new(random.uniform(-4.0, 13.0), 0.0, 0.0) + random.vector(3.0);
            let nearest = DVec3::new(local.x.clamp(0.0, 9.0), 0.0, 0.0);
            let p = sweep.axes.world(local);
            assert_relative_eq!((sweep.axes.local(p) - local).length(), 0.0, epsilon = 1e-12);
            assert_relative_eq!(
                sweep.distance(p),
                local.distance(nearest) - 2.0,
                epsilon = 1e-9
            );
        }
    }

    #[test]
    fn sections_interpolate_their_rows() {
        let rows = [(0.0, 1.0), (2.0, 3.0), (5.0, 2.0), (6.0, 2.5)];
        let sections = rows.map(|(at, e)| Section {
            at,
            centre: [0.1 * at, -at],
            extent: [e, 2.0 * e, 3.0 * e],
        });
        let axes = Axes::new(DVec3::ZERO, DVec3::X, DVec3::Z);
        let sweep = Sweep::new(axes, sections.to_vec(), [1.0, 1.0]);
        for (at, e) in rows {
            let section = sweep.section(at);
            let expected = [0.1 * at, -at, e, 2.0 * e, 3.0 * e];
            for k in 0..5 {
                assert_relative_eq!(section[k], expected[k], epsilon = 1e-12);
            }
        }
    }
}
