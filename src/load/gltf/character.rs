//! A character as its file tells it: a body, its shapes, and what else is there.

use crate::model::{Body, Frame};
use crate::{Error, Result};
use glam::DVec3;

/// A morph target: a direction in which the body's shape varies.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Its name in the file.
    pub name: String,
    /// Its amount where nothing else is said.
    pub default: f64,
    /// Vertices that it moves, rising, with the displacement at amount 1, m.
    pub moves: Vec<(u32, DVec3)>,
}

/// What a character file holds. Made by [`super::read_gltf()`].
#[derive(Clone, Debug, PartialEq)]
pub struct Character {
    /// The body with every shape at 0. All of its surfaces are in `skin`.
    whole: Body,
    /// Directions in which the shape varies; joints stay put.
    pub shapes: Vec<Shape>,
    /// Bones in the file's rest pose: rotation from the reference shape, joint place.
    pub rest: Vec<Frame>,
    /// What was decided about the file and a person may want to know, a sentence each.
    pub notes: Vec<String>,
}

impl Character {
    pub(super) fn new(
        whole: Body,
        shapes: Vec<Shape>,
        rest: Vec<Frame>,
        notes: Vec<String>,
    ) -> Self {
        Self {
            whole,
            shapes,
            rest,
            notes,
        }
    }

    /// The body in the shape of `amounts`, one for each of [`Character::shapes`]; missing ones are at
    /// their defaults. Its layer is not yet meshed.
    ///
    /// # Errors
    /// [`Error::Invalid`] where there are more amounts than shapes, or one is not finite.
    pub fn body(&self, amounts: &[f64]) -> Result<Body> {
        if amounts.len() > self.shapes.len() || amounts.iter().any(|a| !a.is_finite()) {
            let problem = format!("{} finite amounts at most are of use", self.shapes.len());
            return Err(Error::invalid("shape", problem));
        }
        let mut body = self.whole.clone();
        for (k, shape) in self.shapes.iter().enumerate() {
            let amount = amounts.get(k).copied().unwrap_or(shape.default);
            for &(v, d) in &shape.moves {
                body.skin.positions[v as usize] += amount * d;
            }
        }
        Ok(body)
    }
}
