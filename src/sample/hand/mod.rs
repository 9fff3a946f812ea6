//! A generated right hand, laid out like MANO: 16 bones, 3,106 vertices, ten shape directions, 135
//! pose directions.
//!
//! MANO itself may not be shipped; this hand stands in for it. Nothing is read from a file and nothing
//! is copied: the skin is the zero level of an implicit function built from measured proportions
//! (`anatomy`, `shape`), polygonised and remeshed to even triangles (`polygonise`, `remesh`).
//!
//! Frame: metres, wrist joint at the origin, fingers along +x, thumb side +y, back of the hand +z; the
//! palm faces −z. About 19 cm from the wrist to the tip of the middle finger.

mod anatomy;
mod bones;
mod dual_quaternion;
mod field;
mod flesh;
mod palmar;
mod polygonise;
mod pose_columns;
mod poses;
mod regressor;
mod relief;
mod remesh;
mod shape;
mod shape_directions;
mod skin;
mod topology;
mod weights;

use crate::Result;
use crate::model::{ParametricModel, Surface};

/// Lengths are in mm inside this module and in m outside.
const METRE: f64 = 1e-3;

/// The generated hand.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleHand {
    /// Skin, joints, weights and blend shapes, m.
    pub model: ParametricModel,
    /// A closed surface for each bone, in the model's order, m. The wrist's has seven components:
    /// radius, ulna, carpus and four metacarpals.
    pub bones: Vec<Surface>,
    /// For each skin vertex whether it lies on the soft palmar side (palm, eminences, finger pads):
    /// where handles belong.
    pub palmar: Vec<bool>,
}

/// Makes the hand; the same bits every time.
///
/// # Errors
/// [`crate::Error::Solve`] where a fit fails, which it does not for the built-in dimensions.
pub fn hand() -> Result<SampleHand> {
    let digits = anatomy::digits();
    let joints = anatomy::joints(&digits);
    let shape = shape::HandShape::new(&digits);
    let skin = skin::skin(&shape);
    let weights = weights::weights(&shape, &digits, &skin)?;
    let (directions, joint_motions) =
        shape_directions::shape_directions(&digits, &joints, &skin, &weights);
    let joint_regressor =
        regressor::joint_regressor(&skin, &weights, &joints, &directions, &joint_motions)?;
    let palmar = palmar::palmar(&digits, &skin, &weights);
    let in_metres = |points: Vec<glam::DVec3>| -> Vec<glam::DVec3> {
        points.into_iter().map(|p| METRE * p).collect()
    };
    let bones = bones::bones(&digits)
        .into_iter()
        .map(|b| Surface {
            positions: in_metres(b.positions),
            triangles: b.triangles,
        })
        .collect();
    let mut model = ParametricModel {
        template: in_metres(skin.positions),
        triangles: skin.triangles,
        shape_directions: directions.into_iter().map(in_metres).collect(),
        pose_directions: Vec::new(),
        weights,
        joint_regressor,
        parents: (0..16).map(anatomy::parent).collect(),
        names: anatomy::NAMES.map(String::from).to_vec(),
    };
    model.pose_directions = pose_columns::pose_columns(&model, &digits)?;
    Ok(SampleHand {
        model,
        bones,
        palmar,
    })
}
