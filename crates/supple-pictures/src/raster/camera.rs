//! Where a picture is taken from.

use glam::{DMat3, DVec2, DVec3};

/// How depth foreshortens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Vertical angle of view, rad.
    Perspective(f64),
    /// Height of the picture, m.
    Orthographic(f64),
}

/// A pinhole or parallel camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it stands, m.
    pub eye: DVec3,
    /// What it looks at, m.
    pub target: DVec3,
    /// Roughly up.
    pub up: DVec3,
    /// How depth foreshortens.
    pub projection: Projection,
}

impl Camera {
    /// A perspective camera (vertical angle 26°) that looks along `direction` and holds all `points`
    /// in a picture of the given aspect ratio (width over height).
    pub fn framing(points: &[DVec3], direction: DVec3, up: DVec3, aspect: f64) -> Self {
        let angle = 26f64.to_radians();
        let (low, high) = points
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
                (low.min(*p), high.max(*p))
            });
        let mut camera = Self {
            eye: 0.5 * (low + high) - direction.normalize_or(-DVec3::Y),
            target: 0.5 * (low + high),
            up,
            projection: Projection::Perspective(angle),
        };
        let axes = camera.axes();
        // Moving the camera sideways changes what is nearest: a few rounds centre the picture.
        for _ in 0..6 {
            let seen: Vec<_> = (points.iter())
                .map(|p| axes.transpose() * (*p - camera.target))
                .collect();
            // The smallest distance at which every point is inside the frustum, and 8 % of margin.
            let tangent = (0.5 * angle).tan() / 1.08;
            let distance = (seen.iter())
                .map(|v| (v.x.abs() / aspect).max(v.y.abs()) / tangent + v.z)
                .fold(1e-3, f64::max);
            let slopes = seen.iter().map(|v| v.truncate() / (distance - v.z));
            let (least, most) = slopes.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, m), s| {
                (l.min(s), m.max(s))
            });
            camera.eye = camera.target + axes.z_axis * distance;
            let shift = axes * (0.5 * distance * (least + most)).extend(0.0);
            if !shift.is_finite() {
                break;
            }
            camera.target += shift;
            camera.eye += shift;
        }
        camera
    }

    /// [`Camera::framing`] of the ball around `centre`.
    pub fn near(centre: DVec3, radius: f64, direction: DVec3, up: DVec3, aspect: f64) -> Self {
        let corner = |k: usize| {
            let sign = |bit: usize| if k >> bit & 1 == 0 { -radius } else { radius };
            centre + DVec3::new(sign(0), sign(1), sign(2)) / 3f64.sqrt()
        };
        let corners: [DVec3; 8] = std::array::from_fn(corner);
        Self::framing(&corners, direction, up, aspect)
    }

    /// Columns: right, up, backward.
    pub fn axes(&self) -> DMat3 {
        let back = (self.eye - self.target).normalize_or(DVec3::Z);
        let right = self
            .up
            .cross(back)
            .try_normalize()
            .unwrap_or_else(|| back.any_orthonormal_vector());
        DMat3::from_cols(right, back.cross(right), back)
    }
}

/// A camera made ready for one picture size: world → pixels and back.
pub(super) struct Lens {
    eye: DVec3,
    axes: DMat3,
    perspective: bool,
    /// Pixels per metre at distance 1 (perspective) or anywhere (orthographic).
    scale: f64,
    centre: [f64; 2],
}

impl Lens {
    pub fn new(camera: &Camera, width: usize, height: usize) -> Self {
        let (perspective, scale) = match camera.projection {
            Projection::Perspective(angle) => (true, 0.5 * height as f64 / (0.5 * angle).tan()),
            Projection::Orthographic(size) => (false, height as f64 / size),
        };
        Self {
            eye: camera.eye,
            axes: camera.axes(),
            perspective,
            scale,
            centre: [0.5 * width as f64, 0.5 * height as f64],
        }
    }

    /// Pixel x, pixel y (down) and the quantity that is linear on screen and grows towards the
    /// camera: 1/distance (perspective) or −distance. `None` behind the camera.
    pub fn project(&self, point: DVec3) -> Option<[f64; 3]> {
        let v = self.axes.transpose() * (point - self.eye);
        let factor = match self.perspective {
            true if v.z > -1e-6 => return None,
            true => self.scale / -v.z,
            false => self.scale,
        };
        let nearness = if self.perspective { -1.0 / v.z } else { v.z };
        Some([
            self.centre[0] + v.x * factor,
            self.centre[1] - v.y * factor,
            nearness,
        ])
    }

    /// Origin and unit direction of the ray through a place in the picture.
    pub fn ray(&self, x: f64, y: f64) -> (DVec3, DVec3) {
        let u = (x - self.centre[0]) / self.scale;
        let v = (self.centre[1] - y) / self.scale;
        if self.perspective {
            (self.eye, (self.axes * DVec3::new(u, v, -1.0)).normalize())
        } else {
            (
                self.eye + self.axes * DVec3::new(u, v, 0.0),
                -self.axes.z_axis,
            )
        }
    }

    /// Weight by which screen-space barycentric coordinates are corrected for perspective.
    pub fn attribute_weight(&self, nearness: f64) -> f64 {
        if self.perspective { nearness } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_pass_through_what_was_projected() {
        for projection in [Projection::Perspective(0.5), Projection::Orthographic(0.4)] {
            let camera = Camera {
                eye: DVec3::new(0.3, -1.0, 0.4),
                target: DVec3::new(0.05, 0.0, 0.1),
                up: DVec3::Z,
                projection,
            };
            let lens = Lens::new(&camera, 640, 480);
            let point = DVec3::new(0.1, 0.05, 0.02);
            let [x, y, _] = lens.project(point).unwrap();
            let (origin, direction) = lens.ray(x, y);
            assert!((point - origin).cross(direction).length() < 1e-12);
        }
    }

    #[test]
    fn framing_holds_every_point() {
        let points: Vec<DVec3> = (0..50)
            .map(|i| {
                let t = f64::from(i);
                DVec3::new(t.sin(), (1.7 * t).cos(), 0.3 * (2.1 * t).sin())
            })
            .collect();
        let camera = Camera::framing(&points, DVec3::new(-1.0, 2.0, -1.0), DVec3::Z, 1.5);
        let lens = Lens::new(&camera, 300, 200);
        for p in points {
            let [x, y, _] = lens.project(p).unwrap();
            assert!(x > 0.0 && x < 300.0 && y > 0.0 && y < 200.0, "{x} {y}");
        }
    }
}
