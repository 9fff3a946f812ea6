//! SMPL's and MANO's parametric models, as `.npz` archives with their own keys.
//!
//! | key | shape | |
//! |---|---|---|
//! | `v_template` | vertices × 3 | m |
//! | `f` | triangles × 3 | |
//! | `weights` | vertices × bones | rows sum to 1 |
//! | `J_regressor` | bones × vertices | dense |
//! | `kintree_table` | 2 × bones | row 0: parents |
//! | `shapedirs` | vertices × 3 × shapes | optional |
//! | `posedirs` | vertices × 3 × 9 (bones − 1) | optional |
//! | `joint_names` | bones | optional, texts |

use super::array::Array;
use super::arrays::Arrays;
use super::{file, npz, pickle};
use crate::Result;
use crate::math::Rows;
use crate::model::{ParametricModel, SkinWeight};
use glam::DVec3;
use std::path::Path;

/// The arrays of the layout.
const KEYS: [&str; 8] = [
    "v_template",
    "f",
    "weights",
    "J_regressor",
    "kintree_table",
    "shapedirs",
    "posedirs",
    "joint_names",
];

/// MANO's bones, in its order.
const MANO: [&str; 16] = [
    "wrist", "index1", "index2", "index3", "middle1", "middle2", "middle3", "pinky1", "pinky2",
    "pinky3", "ring1", "ring2", "ring3", "thumb1", "thumb2", "thumb3",
];

/// SMPL's bones, in its order.
const SMPL: [&str; 24] = [
    "pelvis",
    "left_hip",
    "right_hip",
    "spine1",
    "left_knee",
    "right_knee",
    "spine2",
    "left_ankle",
    "right_ankle",
    "spine3",
    "left_foot",
    "right_foot",
    "neck",
    "left_collar",
    "right_collar",
    "head",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
    "left_hand",
    "right_hand",
];

/// Sums of weights may miss 1 by this much, as f32 does; they are then normalised.
const SUM_TOLERANCE: f64 = 1e-3;

/// Reads the model at `path`.
///
/// # Errors
/// [`crate::Error::Io`] where the file cannot be read, [`crate::Error::Format`] with the key, what was
/// expected and what was found where it is not such a model.
pub fn read_smpl(path: impl AsRef<Path>) -> Result<ParametricModel> {
    let path = path.as_ref();
    parse_smpl(&file::read_bytes(path)?, path)
}

/// Reads a model from a file's `bytes`; `path` names it in errors. See [`read_smpl`].
pub fn parse_smpl(bytes: &[u8], path: &Path) -> Result<ParametricModel> {
    let archive = if npz::is_archive(bytes) {
        npz::parse(bytes, path, &KEYS)?
    } else {
        pickle::parse(bytes, path, &KEYS)?
    };
    let template = vectors(archive.expect("v_template", &[None, Some(3)])?);
    let vertices = template.len();
    let triangles = read_triangles(&archive, vertices)?;
    let parents = read_parents(&archive)?;
    let bones = parents.len();
    let model = ParametricModel {
        triangles,
        shape_directions: read_directions(&archive, "shapedirs", vertices, None)?,
        pose_directions: read_directions(&archive, "posedirs", vertices, Some(9 * (bones - 1)))?,
        weights: read_weights(&archive, vertices, bones)?,
        joint_regressor: read_regressor(&archive, vertices, bones)?,
        names: read_names(&archive, bones)?,
        parents,
        template,
    };
    Ok(model)
}

/// Rows of three numbers.
fn vectors(array: &Array) -> Vec<DVec3> {
    array
        .numbers
        .chunks_exact(3)
        .map(DVec3::from_slice)
        .collect()
}

fn read_triangles(archive: &Arrays, vertices: usize) -> Result<Vec<[u32; 3]>> {
    let array = archive.expect("f", &[None, Some(3)])?;
    let index = |at: usize| {
        let v = array.numbers[at];
        if v >= 0.0 && v < vertices as f64 && v.fract() == 0.0 {
            Ok(v as u32)
        } else {
            let problem = format!("triangle {} names vertex {v} of {vertices}", at / 3);
            Err(archive.broken("f", problem))
        }
    };
    (0..array.numbers.len() / 3)
        .map(|t| Ok([index(3 * t)?, index(3 * t + 1)?, index(3 * t + 2)?]))
        .collect()
}

/// The root's parent is written as −1 or as that many bits set.
fn read_parents(archive: &Arrays) -> Result<Vec<Option<u32>>> {
    const KEY: &str = "kintree_table";
    let array = archive.expect(KEY, &[Some(2), None])?;
    let bones = array.shape[1];
    let parent = |j: usize| {
        let p = array.numbers[j];
        let none = p < 0.0 || p >= f64::from(u32::MAX);
        if (j == 0 && none) || (j > 0 && p >= 0.0 && p < j as f64 && p.fract() == 0.0) {
            Ok((!none).then_some(p as u32))
        } else {
            let problem = format!(
                "bone {j} has parent {p}: bone 0 must be the only root and parents come first"
            );
            Err(archive.broken(KEY, problem))
        }
    };
    if bones == 0 {
        return Err(archive.broken(KEY, "has no bone"));
    }
    (0..bones).map(parent).collect()
}

/// `directions[k][v]` of an optional vertices × 3 × count array.
fn read_directions(
    archive: &Arrays,
    key: &str,
    vertices: usize,
    count: Option<usize>,
) -> Result<Vec<Vec<DVec3>>> {
    if archive.get(key)?.is_none() {
        return Ok(Vec::new());
    }
    let array = archive.expect(key, &[Some(vertices), Some(3), count])?;
    let count = array.shape[2];
    let at = |k: usize, v: usize, axis: usize| array.numbers[(3 * v + axis) * count + k];
    let direction =
        |k| (0..vertices).map(move |v| DVec3::new(at(k, v, 0), at(k, v, 1), at(k, v, 2)));
    Ok((0..count).map(|k| direction(k).collect()).collect())
}

fn read_weights(archive: &Arrays, vertices: usize, bones: usize) -> Result<Rows<SkinWeight>> {
    const KEY: &str = "weights";
    let array = archive.expect(KEY, &[Some(vertices), Some(bones)])?;
    let mut rows = Rows::default();
    for (v, row) in array.numbers.chunks_exact(bones).enumerate() {
        let sum: f64 = row.iter().sum();
        if row.iter().any(|w| *w < 0.0) || (sum - 1.0).abs() > SUM_TOLERANCE {
            let problem = format!("vertex {v}: weights must be positive and sum to 1, not {sum}");
            return Err(archive.broken(KEY, problem));
        }
        // Sums that are 1 but for rounding are left alone, so that a round trip changes no bit.
        let sum = if (sum - 1.0).abs() < 1e-12 { 1.0 } else { sum };
        rows.push(nonzero(row).map(|(bone, w)| SkinWeight {
            bone,
            weight: w / sum,
        }));
    }
    Ok(rows)
}

fn read_regressor(archive: &Arrays, vertices: usize, bones: usize) -> Result<Rows<(u32, f64)>> {
    const KEY: &str = "J_regressor";
    let rows = archive.nonzero_rows(KEY, [bones, vertices])?;
    for (j, row) in rows.iter().enumerate() {
        let sum: f64 = row.iter().map(|entry| entry.1).sum();
        if (sum - 1.0).abs() > SUM_TOLERANCE {
            return Err(archive.broken(KEY, format!("joint {j}: shares sum to {sum}, not to 1")));
        }
    }
    Ok(rows)
}

/// Index and value of what is not 0.
fn nonzero(row: &[f64]) -> impl Iterator<Item = (u32, f64)> {
    let indexed = row.iter().enumerate().map(|(k, v)| (k as u32, *v));
    indexed.filter(|(_, v)| *v != 0.0)
}

/// The file's own names, else MANO's or SMPL's by their number.
fn read_names(archive: &Arrays, bones: usize) -> Result<Vec<String>> {
    const KEY: &str = "joint_names";
    if let Some(array) = archive.get(KEY)? {
        let mut unique = array.texts.clone();
        unique.sort();
        unique.dedup();
        if array.texts.len() != bones || unique.len() != bones {
            return Err(archive.broken(KEY, format!("{bones} different texts are needed")));
        }
        return Ok(array.texts.clone());
    }
    let known = |names: &[&str]| names.iter().map(ToString::to_string).collect();
    Ok(match bones {
        16 => known(&MANO),
        24 => known(&SMPL),
        _ => (0..bones).map(|j| format!("bone_{j}")).collect(),
    })
}
