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

    /// Its shape, of this half width, m; a hand has none.
    pub fn shape(self, width: f64) -> Option<Shape> {
        match self {
            Self::Hand => None,
            Self::Ball => Some(Shape::Sphere { radius: width }),
            Self::Capsule => Some(Shape::Capsule {
                radius: 0.5 * width,
                half_length: 2.0 * width,
            }),
            Self::Box => Some(Shape::Box {
                half_extents: [width; 3],
            }),
        }
    }

    /// How far its surface is from its middle towards the skin, m.
    fn reach(self, width: f64) -> f64 {
        match self {
            Self::Capsule => 0.5 * width,
            _ => width,
        }
    }
}

/// Fastest that it moves, half widths a second: a cursor jumps, a thing does not.
const FASTEST: f64 = 15.0;
/// How far a notch of the wheel presses it in, and the furthest, in half widths.
const NOTCH: f64 = 0.06;
const DEEPEST: f64 = 4.0;

/// A collider on the cursor.
#[derive(Clone, Debug)]
pub struct Probe {
    key: ColliderId,
    tool: Tool,
    /// Half its width, m.
    width: f64,
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
        width: f64,
    ) -> Result<Option<Self>> {
        let Some(shape) = tool.shape(width) else {
            return Ok(None);
        };
        let touching = hit.distance - tool.reach(width) - GAP * width;
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
            width,
            wanted,
            pressed: 0.0,
            touching,
        }))
    }

    /// Whether it is this tool of this half width, m.
    pub fn is(&self, tool: Tool, width: f64) -> bool {
        self.tool == tool && self.width == width
    }

    /// Follows the cursor: over the skin at its surface, and as far away as it was while it is pressed in.
    pub fn follow(&mut self, ray: &Ray, hit: Option<&Hit>) {
        if let Some(hit) = hit.filter(|_| self.pressed <= 0.0) {
            self.touching = hit.distance - self.tool.reach(self.width) - GAP * self.width;
        }
        self.wanted = ray.at(self.touching + self.pressed);
    }

    /// Presses it in by notches of a wheel.
    pub fn press(&mut self, notches: f64) {
        self.pressed =
            (self.pressed + NOTCH * self.width * notches).clamp(0.0, DEEPEST * self.width);
    }

    /// Moves it on its way for a step of `time_step`, s.
    ///
    /// # Errors
    /// None: it is there.
    pub fn advance(&self, stage: &mut Stage, time_step: f64) -> Result<()> {
        let most = FASTEST * self.width * time_step;
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
            // One mesh for all widths.
            out.extend(self.tool.shape(1.0).map(|shape| Solid {
                scale: DVec3::splat(self.width),
                ..Solid::of_shape(&shape, collider.frame, COLOUR)
            }));
        }
    }
}

/// Between it and the skin that it hovers over, in half widths.
const GAP: f64 = 0.1;
/// Linear red, green, blue.
const COLOUR: [f32; 3] = [0.22, 0.34, 0.5];

/// Axes of a thing that is seen along `direction`: z across the view.
fn facing(direction: DVec3) -> DMat3 {
    let across = direction.any_orthonormal_vector();
    DMat3::from_cols(direction, across.cross(direction), across)
}
