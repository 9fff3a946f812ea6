//! A generated body, laid out like SMPL: 24 bones, ten shape directions, 207 pose directions; its closed
//! skin has 6,890 vertices and 13,776 triangles and is its own mirror image.
//!
//! SMPL itself may not be shipped; this body stands in for it. Nothing is read from a file and nothing is
//! copied: the skin is the zero level of an implicit function built from measured proportions (`anatomy`,
//! `trunk`, `head`, `arm`, `leg`, `shape`), its left half polygonised, remeshed and mirrored (`skin`). Skin
//! weights are heat that flows along the skin from each bone's part of it (`weights`); shape directions are
//! affine maps of the bones, blended by them, and swellings of the soft parts (`shape_directions`); pose
//! directions are fitted to the volume that linear blending loses at bent joints (`sample::pose_columns`,
//! `poses`).
//!
//! Frame: metres, standing on y = 0, +y up, facing +z, +x to the person's left; arms stretched out a little
//! below the horizontal, palms down. 1.72 m tall.

mod anatomy;
mod arm;
mod head;
mod leg;
mod outline;
mod poses;
mod shape;
mod shape_directions;
mod skin;
mod soft;
mod trunk;
mod weights;

use crate::kept::kept;
use crate::pose_columns::pose_columns;
use crate::regressor::{joint_regressor, ring_share};
use glam::DVec3;
use std::sync::Mutex;
use supple::Result;
use supple::model::{JointRange, SkinWeight};
use supple_bake::{Joints, ParametricModel};

/// Lengths are in mm inside this module and in m outside.
const METRE: f64 = 1e-3;

/// The generated body.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleBody {
    /// Skin, joints, weights and blend shapes, m.
    pub model: ParametricModel,
    /// The vertex across the plane of symmetry x = 0 for each vertex; itself where it lies on the plane.
    pub twin: Vec<u32>,
    /// For each vertex whether it lies on a soft part (belly, breast, buttocks, thighs, calves, upper
    /// arms, cheeks): where handles belong.
    pub soft: Vec<bool>,
    /// How far each bone but the pelvis turns.
    pub limits: Vec<(u32, JointRange)>,
}

/// How much a vertex belongs to the ring around joint `j`.
fn closeness(joints: &[DVec3], j: usize, position: DVec3, row: &[SkinWeight]) -> f64 {
    match anatomy::parent(j) {
        Some(p) => ring_share(row, j, p as usize),
        None => {
            let off = (position.y - joints[0].y)
                .abs()
                .max(position.x.abs() - 180.0);
            (1.0 - off / 60.0).max(0.0)
        }
    }
}

/// The body, made once in a process; the same bits every time.
///
/// # Errors
/// [`supple::Error::Solve`] where a fit fails and [`supple::Error::Invalid`] where the skin cannot be
/// remeshed to its count; neither happens with the built-in dimensions.
pub fn body() -> Result<SampleBody> {
    static MADE: Mutex<Option<SampleBody>> = Mutex::new(None);
    kept(&MADE, make)
}

fn make() -> Result<SampleBody> {
    let joints = anatomy::joints();
    let shape = shape::BodyShape::new();
    let skin = skin::skin(&shape)?;
    let weights = weights::weights(&shape, &joints, &skin)?;
    let (directions, joint_motions) = shape_directions::shape_directions(&joints, &skin, &weights);
    let joint_regressor = joint_regressor(
        &skin.surface,
        |j, v| closeness(&joints, j, skin.surface.positions[v], weights.row(v)),
        &joints,
        &directions,
        &joint_motions,
    )?;
    let soft = soft::soft(&skin.surface);
    let in_metres =
        |points: Vec<DVec3>| -> Vec<DVec3> { points.into_iter().map(|p| METRE * p).collect() };
    let mut model = ParametricModel {
        template: in_metres(skin.surface.positions),
        triangles: skin.surface.triangles,
        shape_directions: directions.into_iter().map(in_metres).collect(),
        pose_directions: Vec::new(),
        weights,
        joints: Joints::Regressor(joint_regressor),
        parents: (0..anatomy::BONES).map(anatomy::parent).collect(),
        names: anatomy::NAMES.map(String::from).to_vec(),
    };
    let columns = pose_columns(&model, &poses::Joints(&joints))?;
    model.pose_directions = poses::symmetric_columns(&columns, &skin.twin);
    Ok(SampleBody {
        model,
        twin: skin.twin,
        soft,
        limits: (1..anatomy::BONES)
            .map(|j| (j as u32, poses::limit(j)))
            .collect(),
    })
}
