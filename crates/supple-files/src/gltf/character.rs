//! A character as its file tells it: a body, its shapes, and what else is there.

use crate::tissue::{PartNames, separate_tissue};
use glam::{DQuat, DVec3, Vec3};
use supple::model::{Frame, PoseBlend, SkinWeight, Surface};
use supple::{Error, Result};
use supple_bake::{Attachment, Body};

/// A morph target: a direction in which the body's shape varies.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Its name in the file.
    pub name: String,
    /// Its amount where nothing else is said.
    pub default: f64,
    /// Vertices of all surfaces together that it moves, rising, with the displacement at amount 1, m.
    pub moves: Vec<(u32, DVec3)>,
}

/// All surfaces of a file in one skin, with every shape at 0.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Whole {
    /// `drawn` numbers the skin's vertices and then the copies.
    pub body: Body,
    /// Vertices that are drawn with weights of their own where a skin vertex is.
    pub copies: Vec<(u32, Vec<SkinWeight>)>,
    pub shapes: Vec<Shape>,
}

impl Whole {
    /// Turns the file's normals and tangents as the skin below them turns from this body to `shaped`.
    fn turn_shading(&self, shaped: &mut Body) {
        let [before, after] = [&self.body, &*shaped].map(|body| body.skin.vertex_normals());
        let turns: Vec<DQuat> = before.into_iter().zip(after).map(turn).collect();
        for part in &mut shaped.render_meshes {
            for (i, &v) in part.vertices.iter().enumerate() {
                let skin = match (v as usize).checked_sub(turns.len()) {
                    None => Some(v),
                    Some(copy) => self.copies.get(copy).map(|c| c.0),
                };
                let Some(turn) = skin.and_then(|v| turns.get(v as usize)) else {
                    continue;
                };
                let turned = |[x, y, z]: [f32; 3]| {
                    (*turn * Vec3::new(x, y, z).as_dvec3()).as_vec3().to_array()
                };
                if let Some(normal) = part.normals.get_mut(i) {
                    *normal = turned(*normal);
                }
                if let Some([x, y, z, _]) = part.tangents.get_mut(i) {
                    [*x, *y, *z] = turned([*x, *y, *z]);
                }
            }
        }
    }
}

/// The smallest rotation from one unit vector to another; none where either is 0.
fn turn((from, to): (DVec3, DVec3)) -> DQuat {
    match from.is_normalized() && to.is_normalized() {
        true => DQuat::from_rotation_arc(from, to),
        false => DQuat::IDENTITY,
    }
}

/// What a character file holds. Made by [`super::read_gltf()`].
#[derive(Clone, Debug, PartialEq)]
pub struct Character {
    pub(super) whole: Whole,
    /// Bones in the file's rest pose: rotation from the reference shape, joint place.
    pub rest: Vec<Frame>,
    /// Where it looks: along z, but characters of VRM 0.x along −z.
    pub faces: DVec3,
    /// What was decided about the file and a person may want to know, a sentence each.
    pub notes: Vec<String>,
}

impl Character {
    /// Directions in which the shape varies. Joints stay put.
    pub fn shapes(&self) -> &[Shape] {
        &self.whole.shapes
    }

    /// The body in the shape of `amounts`, one for each of [`Character::shapes`]; missing ones are at
    /// their defaults. What is not tissue is attached ([`separate_tissue`]); the layer is not yet meshed.
    ///
    /// # Errors
    /// [`Error::Invalid`] where there are more amounts than shapes, or one is not finite.
    pub fn body(&self, amounts: &[f64]) -> Result<Body> {
        self.body_of_parts(amounts, &PartNames::default())
    }

    /// [`Character::body`] with parts that are tissue or rigid by name.
    ///
    /// # Errors
    /// As [`Character::body`] and [`separate_tissue`].
    pub fn body_of_parts(&self, amounts: &[f64], named: &PartNames) -> Result<Body> {
        let Whole {
            body,
            copies,
            shapes,
        } = &self.whole;
        if amounts.len() > shapes.len() || amounts.iter().any(|a| !a.is_finite()) {
            let problem = format!("{} finite amounts at most are of use", shapes.len());
            return Err(Error::invalid("shape", problem));
        }
        let mut body = body.clone();
        let mut positions = std::mem::take(&mut body.skin.positions);
        for (k, shape) in shapes.iter().enumerate() {
            let amount = amounts.get(k).copied().unwrap_or(shape.default);
            for &(v, d) in &shape.moves {
                positions[v as usize] += amount * d;
            }
        }
        if !positions.iter().all(|p| p.is_finite()) {
            return Err(Error::invalid("shape", "takes a vertex out of all bounds"));
        }
        let shaped = positions != self.whole.body.skin.positions;
        body.skin.positions = positions;
        if shaped {
            self.whole.turn_shading(&mut body);
        }
        let positions = &body.skin.positions;
        if !copies.is_empty() {
            body.attachments.push(Attachment {
                name: "copies along cuts".into(),
                surface: Surface {
                    positions: copies.iter().map(|(v, _)| positions[*v as usize]).collect(),
                    triangles: Vec::new(),
                },
                skinning: copies.iter().map(|(_, row)| row.clone()).collect(),
                pose_blend: PoseBlend::default(),
                follows_tissue: true,
            });
        }
        separate_tissue(body, named)
    }
}
