//! The parametric models SMPL, SMPL-H, SMPL-X and MANO, as `.npz` archives or the original pickles.
//!
//! | key | shape | |
//! |---|---|---|
//! | `v_template` | vertices × 3 | m |
//! | `f` | triangles × 3 | |
//! | `weights` | vertices × bones | rows sum to 1 |
//! | `J_regressor` | bones × vertices | dense or sparse; rows sum to 1 |
//! | `kintree_table` | 2 × bones | parents (the root's is −1 or all bits set), and the bones' ids |
//! | `shapedirs` | vertices × 3 × shapes | optional; SMPL-X: shape, then expression |
//! | `posedirs` | vertices × 3 × 9 (bones − 1) | optional; or 9 (bones − 1) × 3 vertices |
//! | `joint_names` | bones | optional, texts |
//! | `vertices`, `faces`, `shape_directions`, `pose_directions`, `names` | | other names of `v_template`, `f`, `shapedirs`, `posedirs`, `joint_names` |
//! | `joints`, `joint_directions` | bones × 3, bones × 3 × shapes | in place of `J_regressor`; the second where there are shapes |
//! | `parents` | bones | in place of `kintree_table`: each bone's parent, −1 of the first |
//! | `weight_bones` | vertices × any | the bones that the columns of `weights`, of the same shape, are of |
//! | `hands_mean`, `hands_components` | 45, components × 45 | optional; SMPL-H and SMPL-X: one each with `l` and `r` at its end |
//!
//! Other keys are not read, and any numeric type will do. What the keys mean is the published
//! evaluation (Loper et al. 2015; Romero et al. 2017; Pavlakos et al. 2019), with β and SMPL-X's expression ψ
//! as one list of coefficients:
//!
//! ```text
//! v = T + S (β, ψ)      J = J_regressor v      v += P · (R_j − I of every joint j ≥ 1, row by row)
//! ```

mod fields;
mod hand_pose;
mod names;
#[cfg(test)]
mod published;
#[cfg(test)]
mod tests;
mod write;

pub use hand_pose::HandPose;
pub use write::write_smpl;

use super::{file, npz, pickle};
use crate::arrays::Arrays;
use std::ops::Range;
use std::path::Path;
use supple::Result;
use supple_bake::ParametricModel;

/// Which of the family a model is, by its number of bones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SmplKind {
    /// A body of 24 bones.
    Smpl,
    /// A body with hands, 52 bones.
    SmplH,
    /// A body with hands and face, 55 bones.
    SmplX,
    /// A hand of 16 bones.
    Mano,
    /// Another skeleton in the same layout.
    Other,
}

/// A model of the family with what only some of it have.
#[derive(Clone, Debug, PartialEq)]
pub struct SmplModel {
    /// Which one it is.
    pub kind: SmplKind,
    /// The model; its shape directions are those of β, then those of ψ.
    pub model: ParametricModel,
    /// The model's bone at each place of the file, whose bones may come in any order.
    pub file_order: Vec<u32>,
    /// Shape directions that belong to β.
    pub shapes: usize,
    /// Poses of the hands: MANO's own, or left and right; none where the file has no components.
    pub hands: Vec<HandPose>,
}

impl SmplModel {
    /// Shape and expression as one list of coefficients; what is missing is 0, what is too much is
    /// left out.
    pub fn coefficients(&self, betas: &[f64], expression: &[f64]) -> Vec<f64> {
        let all = self.model.shape_directions.len();
        let shapes = betas.iter().copied().chain(std::iter::repeat(0.0));
        let both = shapes.take(self.shapes).chain(expression.iter().copied());
        both.take(all).collect()
    }
}

/// Columns of `shapedirs` that are β's and ψ's, as the `smplx` package reads SMPL-X: 300 and 100, or 10
/// and 10 in small files. Fewer than 20, and the other models', are all β's.
fn shape_columns(kind: SmplKind, columns: usize) -> (Range<usize>, Range<usize>) {
    match (kind, columns) {
        (SmplKind::SmplX, 400..) => (0..300, 300..400),
        (SmplKind::SmplX, 20..) => (0..10, 10..20),
        _ => (0..columns, columns..columns),
    }
}

/// Reads the model at `path`, without its hands' poses: see [`read_smpl_model`].
///
/// # Errors
/// Those of [`read_smpl_model`].
pub fn read_smpl(path: impl AsRef<Path>) -> Result<ParametricModel> {
    read_smpl_model(path).map(|m| m.model)
}

/// Reads the model at `path`, an `.npz` archive or a pickle; which one, its first bytes tell.
///
/// # Errors
/// [`supple::Error::Io`] where the file cannot be read, [`supple::Error::Format`] with the key, what was
/// expected and what was found where it is not such a model.
pub fn read_smpl_model(path: impl AsRef<Path>) -> Result<SmplModel> {
    let path = path.as_ref();
    parse_smpl(&file::read_bytes(path)?, path)
}

/// Reads a model from a file's `bytes`; `path` names it in errors. See [`read_smpl_model`].
pub fn parse_smpl(bytes: &[u8], path: &Path) -> Result<SmplModel> {
    let arrays = if npz::is_archive(bytes) {
        if npz::holds_any(bytes, &crate::amass::POSES) {
            let problem = "is a motion (AMASS), and a body is needed: name the motion in a scene, or by --motion";
            return Err(supple::Error::format(path, "archive", problem));
        }
        npz::parse(bytes, path, &fields::KEYS)?
    } else {
        pickle::parse(bytes, path, &fields::KEYS)?
    };
    model_of(&arrays)
}

/// The model that `arrays` are.
pub(crate) fn model_of(arrays: &Arrays) -> Result<SmplModel> {
    let template = fields::template(arrays)?;
    let vertices = template.len();
    let tree = fields::tree(arrays)?;
    let bones = tree.parents.len();
    let kind = names::kind(bones);
    let shapes = fields::shape_directions(arrays, vertices)?;
    let (betas, expression) = shape_columns(kind, shapes.len());
    let model = ParametricModel {
        triangles: fields::triangles(arrays, vertices)?,
        shape_directions: [&shapes[betas.clone()], &shapes[expression]].concat(),
        pose_directions: fields::pose_directions(arrays, vertices, &tree)?,
        weights: fields::weights(arrays, vertices, &tree)?,
        joints: fields::joints(arrays, vertices, &tree, shapes.len())?,
        names: fields::names(arrays, kind, &tree)?,
        parents: tree.parents.clone(),
        template,
    };
    Ok(SmplModel {
        kind,
        model,
        file_order: (0..bones).map(|j| tree.index_of(j)).collect(),
        shapes: betas.len(),
        hands: hand_pose::read(arrays, kind, &tree)?,
    })
}
