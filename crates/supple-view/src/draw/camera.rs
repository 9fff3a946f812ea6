//! A camera that turns about what it looks at, and the ray under the cursor.

use glam::camera::rh::proj::directx;
use glam::{DMat3, DVec3, Mat4, Vec3};
use supple::model::UpAxis;

/// Vertical angle of view, rad.
const OPENING: f64 = 0.6;

/// Where it looks, from which side, from how far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// What points up.
    pub up: UpAxis,
    /// m, in the world.
    pub target: DVec3,
    /// About the axis that points up, and above the horizon; radians.
    pub angles: [f64; 2],
    /// m.
    pub distance: f64,
}

/// A half-line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// m.
    pub origin: DVec3,
    /// Unit.
    pub direction: DVec3,
}

impl Ray {
    /// The point so far along, m.
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + distance * self.direction
    }
}

impl Camera {
    /// One that sees all of a box, in a world where `up` points up.
    pub fn around([low, high]: [DVec3; 2], up: UpAxis) -> Self {
        Self {
            up,
            target: 0.5 * (low + high),
            angles: [0.6, 0.2],
            distance: 1.9 * (high - low).length().max(0.02),
        }
    }

    /// Turns by radians, to the right and up.
    pub fn turn(&mut self, [about, above]: [f64; 2]) {
        self.angles[0] -= about;
        self.angles[1] = (self.angles[1] + above).clamp(-0.3, 1.5);
    }

    /// Comes nearer by notches of a wheel.
    pub fn come_near(&mut self, notches: f64) {
        self.distance = (self.distance * 0.9f64.powf(notches)).clamp(0.02, 100.0);
    }

    /// Moves aside by parts of the picture's height, right and down.
    pub fn shift(&mut self, [right, down]: [f64; 2]) {
        let axes = self.axes();
        let height = 2.0 * self.distance * (0.5 * OPENING).tan();
        self.target += height * (down * axes.y_axis - right * axes.x_axis);
    }

    /// Right, up and towards the eye, in the world.
    pub fn axes(&self) -> DMat3 {
        let [about, above] = self.angles;
        // In a world of z up, from the front: characters face −y there.
        let back = DVec3::new(
            about.sin() * above.cos(),
            -about.cos() * above.cos(),
            above.sin(),
        );
        let right = DVec3::new(about.cos(), about.sin(), 0.0);
        let standing = UpAxis::Z.rotation_to(self.up);
        standing * DMat3::from_cols(right, back.cross(right), back)
    }

    /// Where it stands, m.
    pub fn eye(&self) -> DVec3 {
        self.target + self.distance * self.axes().z_axis
    }

    /// From places relative to the target to the picture, `aspect` times as wide as it is high.
    pub fn view_projection(&self, aspect: f64) -> Mat4 {
        let axes = self.axes().transpose().as_mat3();
        let back = Vec3::new(0.0, 0.0, -self.distance as f32);
        let look = Mat4::from_translation(back) * Mat4::from_mat3(axes);
        let (near, far) = (
            0.02 * self.distance as f32,
            30.0 * self.distance as f32 + 30.0,
        );
        directx::perspective(OPENING as f32, aspect as f32, near, far) * look
    }

    /// The ray through a place of the picture: from −1 at the left and below to 1 at the right and above.
    pub fn ray(&self, [x, y]: [f64; 2], aspect: f64) -> Ray {
        let slope = (0.5 * OPENING).tan();
        let direction = self.axes() * DVec3::new(x * slope * aspect, y * slope, -1.0);
        Ray {
            origin: self.eye(),
            direction: direction.normalize(),
        }
    }

    /// Where a point of the world is in the picture, as [`Camera::ray`] counts; none of what is behind the eye.
    pub fn project(&self, point: DVec3, aspect: f64) -> Option<[f64; 2]> {
        let seen = self.axes().transpose() * (point - self.eye());
        let slope = (0.5 * OPENING).tan();
        (seen.z < 0.0).then(|| {
            [
                seen.x / (-seen.z * slope * aspect),
                seen.y / (-seen.z * slope),
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_ray_meets_is_seen_where_it_was_shot_and_drawn_there() {
        for up in [UpAxis::Y, UpAxis::Z] {
            let mut camera =
                Camera::around([DVec3::new(-1.0, 0.0, 0.5), DVec3::new(1.0, 2.0, 3.0)], up);
            camera.turn([0.4, 0.3]);
            camera.shift([0.1, 0.2]);
            let (at, aspect) = ([0.4, -0.7], 1.6);
            let ray = camera.ray(at, aspect);
            let point = ray.at(0.8 * camera.distance);
            let seen = camera.project(point, aspect).unwrap();
            assert!((seen[0] - at[0]).abs() + (seen[1] - at[1]).abs() < 1e-12);
            let relative = (point - camera.target).as_vec3();
            let drawn = camera.view_projection(aspect).project_point3(relative);
            assert!(
                (drawn.x - 0.4).abs() + (drawn.y + 0.7).abs() < 1e-4,
                "{drawn}"
            );
            assert!((0.0..1.0).contains(&drawn.z), "{drawn}");
            assert!(camera.axes().y_axis.dot(up.direction()) > 0.5);
            assert!(
                camera
                    .project(camera.eye() + camera.axes().z_axis, 1.0)
                    .is_none()
            );
        }
    }
}
