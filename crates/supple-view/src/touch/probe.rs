//! A thing on the cursor: it hovers over the skin, and the wheel presses it in.

use super::pick::Hit;
use crate::draw::{Ray, Solid};
use crate::stage::Stage;
use glam::{DMat3, DVec3};
use supple::Result;
use supple::collider::{Collider, Shape};
use supple::model::Frame;
use supple::world::ColliderId;

/// What is on the cursor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tool {
    /// A hand that grabs.
    #[default]
    Hand,
    /// A ball.
    Ball,
    /// A capsule, across the view.
    Capsule,
    /// A box.
    Box,
}

impl Tool {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Hand, Self::Ball, Self::Capsule, Self::Box];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::Hand => "hand",
            Self::Ball => "ball",
            Self::Capsule => "capsule",
            Self::Box => "box",
        }
    }

    /// Its shape, for a character of this size, m; a hand has none.
    pub fn shape(self, size: f64) -> Option<Shape> {
        let radius = 0.035 * size;
        match self {
            Self::Hand => None,
            Self::Ball => Some(Shape::Sphere { radius }),
            Self::Capsule => Some(Shape::Capsule {
                radius: 0.5 * radius,
                half_length: 2.0 * radius,
            }),
            Self::Box => Some(Shape::Box {
                half_extents: [radius; 3],
            }),
        }
    }

    /// How far its surface is from its middle towards the skin, m.
    fn reach(self, size: f64) -> f64 {
        match self {
            Self::Capsule => 0.0175 * size,
            _ => 0.035 * size,
        }
    }
}

/// Fastest that it moves, sizes of the character a second: a cursor jumps, a thing does not.
const FASTEST: f64 = 0.8;

/// A collider on the cursor.
#[derive(Clone, Debug)]
pub struct Probe {
    key: ColliderId,
    tool: Tool,
    size: f64,
    /// Where its middle is to be, m.
    wanted: DVec3,
    /// How far it is pressed in from where it just touches, m.
    pub pressed: f64,
    /// From the eye to where it just touches, along the ray, m: kept while it is pressed in.
    touching: f64,
}

impl Probe {
    /// A thing that just touches where the cursor meets the skin. None of a hand.
    ///
    /// # Errors
    /// None: its shape is sound.
    pub fn new(
        stage: &mut Stage,
        tool: Tool,
        ray: &Ray,
        hit: &Hit,
        size: f64,
    ) -> Result<Option<Self>> {
        let Some(shape) = tool.shape(size) else {
            return Ok(None);
        };
        let touching = hit.distance - tool.reach(size) - GAP * size;
        let wanted = ray.at(touching);
        let frame = Frame {
            // A capsule lies across the view, a box faces it.
            rotation: facing(ray.direction),
            position: wanted,
        };
        let mut collider = Collider::new(shape, frame);
        collider.friction = 0.5;
        Ok(Some(Self {
            key: stage.world.add_collider(collider)?,
            tool,
            size,
            wanted,
            pressed: 0.0,
            touching,
        }))
    }

    /// What it is.
    pub fn tool(&self) -> Tool {
        self.tool
    }

    /// Follows the cursor: over the skin at its surface, and as far away as it was while it is pressed in.
    pub fn follow(&mut self, ray: &Ray, hit: Option<&Hit>) {
        if let Some(hit) = hit.filter(|_| self.pressed <= 0.0) {
            self.touching = hit.distance - self.tool.reach(self.size) - GAP * self.size;
        }
        self.wanted = ray.at(self.touching + self.pressed);
    }

    /// Presses it in by notches of a wheel.
    pub fn press(&mut self, notches: f64) {
        self.pressed = (self.pressed + 0.004 * self.size * notches).clamp(0.0, 0.3 * self.size);
    }

    /// Moves it on its way for a step of `time_step`, s.
    ///
    /// # Errors
    /// None: it is there.
    pub fn advance(&self, stage: &mut Stage, time_step: f64) -> Result<()> {
        let most = FASTEST * self.size * time_step;
        let frame = &mut stage.world.collider_mut(self.key)?.frame;
        frame.position += (self.wanted - frame.position).clamp_length_max(most);
        Ok(())
    }

    /// Takes it away.
    ///
    /// # Errors
    /// None: it is there.
    pub fn remove(self, stage: &mut Stage) -> Result<()> {
        stage.world.remove_collider(self.key).map(drop)
    }

    /// It, where it is.
    pub fn solids(&self, stage: &mut Stage, out: &mut Vec<Solid>) {
        if let Ok(collider) = stage.world.collider_mut(self.key) {
            out.push(Solid::of_shape(&collider.shape, collider.frame, COLOUR));
        }
    }
}

/// Between it and the skin that it hovers over, in sizes of the character.
const GAP: f64 = 0.004;
/// Linear red, green, blue.
const COLOUR: [f32; 3] = [0.22, 0.34, 0.5];

/// Axes of a thing that is seen along `direction`: z across the view.
fn facing(direction: DVec3) -> DMat3 {
    let across = direction.any_orthonormal_vector();
    DMat3::from_cols(direction, across.cross(direction), across)
}
