//! A camera that turns about what it looks at.

use supple::glam::camera::rh::{proj::directx, view};
use supple::glam::{DVec3, Mat4, Vec3};

/// Where it looks, from which side, from how far.
#[derive(Clone, Copy)]
pub struct Camera {
    /// m, in the world.
    pub target: DVec3,
    /// About the vertical axis, and above the horizon; radians.
    pub angles: [f32; 2],
    /// m.
    pub distance: f32,
}

impl Camera {
    pub fn turn(&mut self, by: [f32; 2]) {
        self.angles[0] -= by[0];
        self.angles[1] = (self.angles[1] + by[1]).clamp(-0.1, 1.5);
    }

    pub fn come_near(&mut self, notches: f32) {
        self.distance = (self.distance * 0.9f32.powf(notches)).clamp(0.1, 50.0);
    }

    /// From places relative to the target to the picture, `aspect` times as wide as it is high.
    pub fn view_projection(&self, aspect: f32) -> Mat4 {
        let [about, above] = self.angles;
        let side = Vec3::new(
            about.sin() * above.cos(),
            above.sin(),
            about.cos() * above.cos(),
        );
        let look = view::look_at_mat4(self.distance * side, Vec3::ZERO, Vec3::Y);
        directx::perspective(0.6, aspect, 0.05, 100.0) * look
    }
}
