//! Balls that are thrown.

use crate::draw::{Ray, Solid};
use crate::stage::Stage;
use glam::DVec3;
use std::collections::VecDeque;
use supple::Result;
use supple::collider::Shape;
use supple::model::{Frame, RigidBody};
use supple::world::BodyId;

/// Most that lie about: the oldest goes when another comes.
const MOST: usize = 4;
/// kg/m³.
const DENSITY: f64 = 1000.0;
/// Linear red, green, blue.
const COLOUR: [f32; 3] = [0.75, 0.3, 0.03];

/// Balls in the world, the oldest first.
#[derive(Clone, Debug, Default)]
pub struct Balls {
    bodies: VecDeque<BodyId>,
    thrown: usize,
    radius: f64,
}

impl Balls {
    /// Throws one from the eye along `ray` at a character of this size, m, half of the way `away` (m) before it.
    ///
    /// # Errors
    /// Limits of the device.
    pub fn throw(&mut self, stage: &mut Stage, ray: &Ray, away: f64, size: f64) -> Result<()> {
        if self.bodies.len() == MOST
            && let Some(oldest) = self.bodies.pop_front()
        {
            stage.world.remove_body(oldest)?;
        }
        self.radius = 0.06 * size;
        self.thrown += 1;
        let name = format!("ball {}", self.thrown);
        let shape = Shape::Sphere {
            radius: self.radius,
        };
        let mut body = RigidBody::new(name, shape, DENSITY)?;
        body.friction = 0.4;
        let up = stage.world.up().direction();
        let start = ray.at(0.5 * away);
        let frame = Frame {
            position: start,
            ..Frame::IDENTITY
        };
        let id = stage.world.add_body(body.at(frame))?;
        // As fast as looks right at this size; the fall on the way is aimed away.
        let flight = 0.2 * size.sqrt();
        let fall = 0.5 * flight * stage.world.gravity().dot(up);
        let velocity = ray.direction * (0.5 * away / flight) - fall * up;
        stage
            .world
            .set_body_motion(id, &frame, velocity, DVec3::ZERO)?;
        self.bodies.push_back(id);
        Ok(())
    }

    /// Forgets them: the world has been put back.
    pub fn forget(&mut self) {
        self.bodies.clear();
    }

    /// Them, where they are.
    pub fn solids(&self, stage: &Stage, out: &mut Vec<Solid>) {
        let shape = Shape::Sphere {
            radius: self.radius,
        };
        let frames = self
            .bodies
            .iter()
            .filter_map(|b| stage.world.body_frame(*b).ok());
        out.extend(frames.map(|frame| Solid::of_shape(&shape, frame, COLOUR)));
    }
}
