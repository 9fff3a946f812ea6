//! How the parts of the body are written down: tables of sections, bulges and cords. Lengths in mm.

use super::anatomy::mirrored;
use crate::field::{Axes, Ellipsoid, Section, Sweep, smooth_min};
use glam::DVec3;

/// A horizontal section: height, centre (x, z), half width, depth in front of the centre and behind it.
pub(super) type Level = [f64; 6];

/// A column of horizontal sections, highest first, with the heights of its upper and lower cap.
pub(super) fn column(levels: &[Level], caps: [f64; 2]) -> Sweep {
    // Down, so that lateral is +x; dorsal is forward.
    let axes = Axes::new(DVec3::ZERO, DVec3::NEG_Y, DVec3::Z);
    let sections = levels
        .iter()
        .map(|&[y, x, z, width, front, back]| Section {
            at: -y,
            centre: [x, z],
            extent: [width, front, back],
        })
        .collect();
    Sweep::new(axes, sections, caps)
}

/// A part that is blended into what it lies on.
#[derive(Clone, Debug)]
pub(super) struct Bulge {
    shape: BulgeShape,
    /// Middle and radius of a ball beyond which it has no effect.
    middle: DVec3,
    reach: f64,
    blend: f64,
}

#[derive(Clone, Debug)]
enum BulgeShape {
    Ellipsoid(Ellipsoid),
    Cord(Box<Sweep>),
}

impl Bulge {
    /// An ellipsoid with its axes along x, y and z.
    pub fn ball(centre: [f64; 3], radii: [f64; 3], blend: f64) -> Self {
        Self::ellipsoid(centre, DVec3::X, DVec3::Z, radii, blend)
    }

    /// An ellipsoid; its first axis is `along`, its third nearly `dorsal`.
    pub fn ellipsoid(
        centre: [f64; 3],
        along: DVec3,
        dorsal: DVec3,
        radii: [f64; 3],
        blend: f64,
    ) -> Self {
        let (middle, radii) = (DVec3::from_array(centre), DVec3::from_array(radii));
        Self {
            shape: BulgeShape::Ellipsoid(Ellipsoid {
                axes: Axes::new(middle, along, dorsal),
                radii,
            }),
            middle,
            reach: radii.max_element() + 2.0 * blend,
            blend,
        }
    }

    /// A round cord through three points with its radius at each.
    pub fn cord(points: [[f64; 3]; 3], radii: [f64; 3], blend: f64) -> Self {
        let points = points.map(DVec3::from_array);
        let chord = points[2] - points[0];
        let dorsal = if chord.normalize().z.abs() < 0.8 {
            DVec3::Z
        } else {
            DVec3::Y
        };
        let axes = Axes::new(points[0], chord, dorsal);
        let sections = (0..3)
            .map(|k| {
                let local = axes.local(points[k]);
                Section {
                    at: local.x,
                    centre: [local.y, local.z],
                    extent: [radii[k]; 3],
                }
            })
            .collect();
        let caps = [radii[0], radii[2]];
        let thick = radii.into_iter().fold(0.0, f64::max);
        Self {
            shape: BulgeShape::Cord(Box::new(Sweep::new(axes, sections, caps))),
            middle: 0.5 * (points[0] + points[2]),
            reach: 0.5 * chord.length() + 2.0 * thick + 2.0 * blend,
            blend,
        }
    }

    /// `base` with the bulge blended in.
    pub fn join(&self, base: f64, p: DVec3) -> f64 {
        if p.distance_squared(self.middle) > self.reach * self.reach {
            return base;
        }
        smooth_min(base, self.distance(p), self.blend)
    }

    /// `base` with the bulge and its mirror image blended in, these two with a blend of their own.
    pub fn join_pair(&self, base: f64, p: DVec3, between: f64) -> f64 {
        let reach = self.reach + between;
        if p.distance_squared(self.middle) > reach * reach && p.x > 0.5 * self.reach {
            return base;
        }
        let pair = smooth_min(self.distance(p), self.distance(mirrored(p)), between);
        smooth_min(base, pair, self.blend)
    }

    /// `base` without the bulge's inside.
    pub fn carve(&self, base: f64, p: DVec3) -> f64 {
        if p.distance_squared(self.middle) > self.reach * self.reach {
            return base;
        }
        -smooth_min(-base, self.distance(p), self.blend)
    }

    /// The bulge's own field.
    pub fn distance(&self, p: DVec3) -> f64 {
        match &self.shape {
            BulgeShape::Ellipsoid(e) => e.distance(p),
            BulgeShape::Cord(s) => s.distance(p),
        }
    }
}

/// `exp(−t²)`: the profile of a soft groove or ridge.
pub(super) fn bell(t: f64) -> f64 {
    (-t * t).exp()
}
