//! A generated right hand, laid out like MANO: 16 bones, ten shape directions, 135 pose directions; its
//! closed skin has 3,106 vertices and 6,208 triangles.
//!
//! MANO itself may not be shipped; this hand stands in for it. Nothing is read from a file and nothing
//! is copied: the skin is the zero level of an implicit function built from measured proportions
//! (`anatomy`, `flesh`, `relief`, `shape`), polygonised and remeshed. Skin
//! weights are heat that flows along the skin from each bone's segment (`weights`); shape directions are
//! affine maps of the bones, blended by them (`shape_directions`); pose directions are fitted to the
//! volume that linear blending loses at bent joints (`sample::pose_columns`).
//!
//! Frame: metres, wrist joint at the origin, fingers along +x, thumb side +y, back of the hand +z; the
//! palm faces −z. About 19 cm from the wrist to the tip of the middle finger.

mod anatomy;
mod bones;
mod flesh;
mod grasp;
mod palmar;
mod poses;
mod relief;
mod shape;
mod shape_directions;
mod skin;
mod weights;

pub(super) use anatomy::digits;
pub use grasp::grasp;
pub(super) use shape::HandShape;

use crate::kept::kept;
use crate::pose_columns::pose_columns;
use crate::regressor::{joint_regressor, ring_share};
use std::sync::Mutex;
use supple::Result;
use supple::model::{JointRange, SkinWeight, Surface};
use supple_bake::{Joints, ParametricModel};

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
    /// How far each bone but the wrist turns.
    pub limits: Vec<(u32, JointRange)>,
}

/// How much a vertex belongs to the ring around joint `j`.
fn closeness(j: usize, position: glam::DVec3, row: &[SkinWeight]) -> f64 {
    match anatomy::parent(j) {
        Some(p) => ring_share(row, j, p as usize),
        None => (1.0 - position.x.abs() / 12.0).max(0.0),
    }
}

/// The hand, made once in a process; the same bits every time.
///
/// # Errors
/// [`supple::Error::Solve`] where a fit fails and [`supple::Error::Invalid`] where the skin cannot be
/// remeshed to its count; neither happens with the built-in dimensions.
pub fn hand() -> Result<SampleHand> {
    static MADE: Mutex<Option<SampleHand>> = Mutex::new(None);
    kept(&MADE, make)
}

fn make() -> Result<SampleHand> {
    let digits = digits();
    let joints = anatomy::joints(&digits);
    let shape = HandShape::new(&digits);
    let skin = skin::skin(&shape)?;
    let weights = weights::weights(&shape, &digits, &skin)?;
    let (directions, joint_motions) =
        shape_directions::shape_directions(&digits, &joints, &skin, &weights);
    let joint_regressor = joint_regressor(
        &skin,
        |j, v| closeness(j, skin.positions[v], weights.row(v)),
        &joints,
        &directions,
        &joint_motions,
    )?;
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
        joints: Joints::Regressor(joint_regressor),
        parents: (0..16).map(anatomy::parent).collect(),
        names: anatomy::NAMES.map(String::from).to_vec(),
    };
    model.pose_directions = pose_columns(&model, &digits)?;
    Ok(SampleHand {
        model,
        bones,
        palmar,
        limits: (1..16)
            .map(|j| (j as u32, poses::range(&digits, j)))
            .collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use supple::internal::math::par_map;

    #[test]
    fn regressed_joints_follow_every_shape_direction() {
        let digits = digits();
        let joints = anatomy::joints(&digits);
        let shape = HandShape::new(&digits);
        let skin = skin::skin(&shape).unwrap();
        let weights = weights::weights(&shape, &digits, &skin).unwrap();
        let (directions, motions) =
            shape_directions::shape_directions(&digits, &joints, &skin, &weights);
        let rows = joint_regressor(
            &skin,
            |j, v| closeness(j, skin.positions[v], weights.row(v)),
            &joints,
            &directions,
            &motions,
        )
        .unwrap();
        let regress = |j: usize, field: &[glam::DVec3]| -> glam::DVec3 {
            rows.row(j)
                .iter()
                .map(|&(v, a)| a * field[v as usize])
                .sum()
        };
        let errors = par_map(16, |j| {
            let place = regress(j, &skin.positions).distance(joints[j]);
            let moved = directions.iter().zip(&motions);
            let drift = moved.map(|(d, m)| regress(j, d).distance(m[j]));
            (place, drift.fold(0.0, f64::max))
        });
        for (j, (place, drift)) in errors.into_iter().enumerate() {
            // mm, and mm a unit.
            assert!(place < 1e-3, "joint {j} is {place} off");
            assert!(drift < 0.05, "joint {j} drifts by {drift}");
            let largest = rows.row(j).iter().fold(0.0, |m: f64, r| m.max(r.1.abs()));
            assert!(largest < 1.0, "joint {j} hangs on one vertex: {largest}");
        }
    }
}
