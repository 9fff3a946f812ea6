//! The keys of a model, each checked and read.

use super::{SmplKind, names as published};
use crate::array::Array;
use crate::arrays::{Arrays, summed};
use glam::DVec3;
use supple::Result;
use supple::internal::math::Rows;
use supple::model::SkinWeight;
use supple_bake::Joints;

/// Names that an array has: SMPL's, and that of [`crate::BodyArrays`].
const VERTICES: [&str; 2] = ["v_template", "vertices"];
const FACES: [&str; 2] = ["f", "faces"];
const SHAPES: [&str; 2] = ["shapedirs", "shape_directions"];
const POSES: [&str; 2] = ["posedirs", "pose_directions"];
const NAMES: [&str; 2] = ["joint_names", "names"];

/// The arrays of the layout.
pub(super) const KEYS: [&str; 23] = [
    VERTICES[0],
    VERTICES[1],
    FACES[0],
    FACES[1],
    "weights",
    "weight_bones",
    "J_regressor",
    "joints",
    "joint_directions",
    "kintree_table",
    "parents",
    SHAPES[0],
    SHAPES[1],
    POSES[0],
    POSES[1],
    NAMES[0],
    NAMES[1],
    "hands_mean",
    "hands_meanl",
    "hands_meanr",
    "hands_components",
    "hands_componentsl",
    "hands_componentsr",
];

/// Sums of weights may miss 1 by this much, as f32 does; they are then normalised.
const SUM_TOLERANCE: f64 = 1e-3;

/// A weight below 0 by no more than this is rounding.
const NEGATIVE_TOLERANCE: f64 = 1e-6;

/// Most bones that a model may have.
const MOST_BONES: usize = 4096;

/// The bones' tree, its parents before their children.
pub(super) struct Tree {
    pub parents: Vec<Option<u32>>,
    /// The file's index of each bone.
    order: Vec<usize>,
    /// The bone of each of the file's indices.
    index: Vec<u32>,
}

impl Tree {
    /// The bone at place `old` of the file.
    pub fn index_of(&self, old: usize) -> u32 {
        self.index[old]
    }
}

pub(super) fn template(arrays: &Arrays) -> Result<Vec<DVec3>> {
    let key = arrays.called(VERTICES);
    let array = arrays.expect(key, &[None, Some(3)])?;
    if array.numbers.is_empty() {
        return Err(arrays.broken(key, "has no vertex"));
    }
    Ok(vectors(array))
}

fn vectors(array: &Array) -> Vec<DVec3> {
    array
        .numbers
        .chunks_exact(3)
        .map(DVec3::from_slice)
        .collect()
}

pub(super) fn triangles(arrays: &Arrays, vertices: usize) -> Result<Vec<[u32; 3]>> {
    let key = arrays.called(FACES);
    let array = arrays.expect(key, &[None, Some(3)])?;
    let index = |at: usize| {
        let v = array.numbers[at];
        if v >= 0.0 && v < vertices as f64 && v.fract() == 0.0 {
            Ok(v as u32)
        } else {
            let problem = format!("triangle {} names vertex {v} of {vertices}", at / 3);
            Err(arrays.broken(key, problem))
        }
    };
    (0..array.numbers.len() / 3)
        .map(|t| Ok([index(3 * t)?, index(3 * t + 1)?, index(3 * t + 2)?]))
        .collect()
}

/// `kintree_table`: row 0 names each bone's parent by its id, row 1 the bones' ids; or `parents`: each bone's parent by
/// its place. The first bone is the only root.
pub(super) fn tree(arrays: &Arrays) -> Result<Tree> {
    const KEYS: [&str; 2] = ["kintree_table", "parents"];
    let key = arrays.called(KEYS);
    let table = key == KEYS[0];
    let shape = [Some(2), None];
    let array = arrays.expect(key, if table { &shape } else { &shape[1..] })?;
    let bones = array.shape[array.shape.len() - 1];
    if !(1..=MOST_BONES).contains(&bones) {
        return Err(arrays.broken(key, format!("has {bones} bones, not 1 to {MOST_BONES}")));
    }
    let places: Vec<f64> = (0..bones).map(|j| j as f64).collect();
    let (parents, ids) = match table {
        true => array.numbers.split_at(bones),
        false => (&array.numbers[..], &places[..]),
    };
    let place = |id: f64| ids.iter().position(|i| *i == id);
    if let Some(j) = (0..bones).find(|&j| place(ids[j]) != Some(j)) {
        return Err(arrays.broken(key, format!("bones share the id {}", ids[j])));
    }
    let mut parent_of = Vec::with_capacity(bones);
    for (j, &parent) in parents.iter().enumerate() {
        // The root's parent is −1, or as many bits set as its type has.
        let root = parent < 0.0 || parent >= f64::from(u32::MAX);
        parent_of.push(match place(parent) {
            _ if root && j == 0 => None,
            Some(p) if !root && p != j && j > 0 => Some(p),
            _ => {
                let problem = format!(
                    "bone {j} has parent {parent}: bone 0 must be the only root, and every other bone's \
                     parent another bone"
                );
                return Err(arrays.broken(key, problem));
            }
        });
    }
    sorted(&parent_of).ok_or_else(|| arrays.broken(key, "the bones' parents go round in a circle"))
}

/// The tree with parents first, otherwise in the file's order; none where it is no tree.
fn sorted(parent_of: &[Option<usize>]) -> Option<Tree> {
    let mut order: Vec<usize> = Vec::with_capacity(parent_of.len());
    let mut index = vec![u32::MAX; parent_of.len()];
    while order.len() < parent_of.len() {
        let known = order.len();
        for (j, parent) in parent_of.iter().enumerate() {
            if index[j] == u32::MAX && parent.is_none_or(|p| index[p] != u32::MAX) {
                index[j] = order.len() as u32;
                order.push(j);
            }
        }
        if order.len() == known {
            return None;
        }
    }
    let parents = order.iter().map(|&j| parent_of[j].map(|p| index[p]));
    Some(Tree {
        parents: parents.collect(),
        order,
        index,
    })
}

/// `directions[k][v]` of the optional `shapedirs`.
pub(super) fn shape_directions(arrays: &Arrays, vertices: usize) -> Result<Vec<Vec<DVec3>>> {
    directions(arrays, arrays.called(SHAPES), vertices)
}

/// `directions[k][point]` of the optional points × 3 × count array `key`.
fn directions(arrays: &Arrays, key: &str, points: usize) -> Result<Vec<Vec<DVec3>>> {
    if arrays.get(key)?.is_none() {
        return Ok(Vec::new());
    }
    let array = arrays.expect(key, &[Some(points), Some(3), None])?;
    let direction = |k| last_index(array, points, k);
    Ok((0..array.shape[2]).map(direction).collect())
}

/// `directions[k][v]` of the optional `posedirs`, nine a bone but the first.
pub(super) fn pose_directions(
    arrays: &Arrays,
    vertices: usize,
    tree: &Tree,
) -> Result<Vec<Vec<DVec3>>> {
    let key = arrays.called(POSES);
    let features = 9 * (tree.order.len() - 1);
    let Some(array) = arrays.get(key)? else {
        return Ok(Vec::new());
    };
    let flat = array.shape.len() == 2;
    if flat {
        arrays.expect(key, &[Some(features), Some(3 * vertices)])?;
    } else {
        arrays.expect(key, &[Some(vertices), Some(3), Some(features)])?;
    }
    let direction = |k: usize| -> Vec<DVec3> {
        if flat {
            let row = &array.numbers[k * 3 * vertices..(k + 1) * 3 * vertices];
            row.chunks_exact(3).map(DVec3::from_slice).collect()
        } else {
            last_index(array, vertices, k)
        }
    };
    let of_bone = |&old: &usize| (9 * (old - 1)..9 * old).map(direction);
    Ok(tree.order[1..].iter().flat_map(of_bone).collect())
}

/// The vectors at `k` of a vertices × 3 × count array.
fn last_index(array: &Array, vertices: usize, k: usize) -> Vec<DVec3> {
    let count = array.shape[2];
    let at = |v: usize, axis: usize| array.numbers[(3 * v + axis) * count + k];
    (0..vertices)
        .map(|v| DVec3::new(at(v, 0), at(v, 1), at(v, 2)))
        .collect()
}

pub(super) fn weights(arrays: &Arrays, vertices: usize, tree: &Tree) -> Result<Rows<SkinWeight>> {
    const KEY: &str = "weights";
    let bones = tree.order.len();
    let read = match arrays.get(WEIGHT_BONES)? {
        None => arrays.nonzero_rows(KEY, [vertices, bones])?,
        Some(_) => named_weights(arrays, KEY, [vertices, bones])?,
    };
    let mut rows = Rows::default();
    for (v, row) in read.iter().enumerate() {
        let sum: f64 = row.iter().map(|w| w.1).sum();
        if row.iter().any(|w| w.1 < -NEGATIVE_TOLERANCE) || (sum - 1.0).abs() > SUM_TOLERANCE {
            let problem = format!("vertex {v}: weights must be positive and sum to 1, not {sum}");
            return Err(arrays.broken(KEY, problem));
        }
        let positive = row.iter().filter(|w| w.1 > 0.0);
        let sum: f64 = positive.clone().map(|w| w.1).sum();
        // Sums that are 1 but for rounding are left alone, so that a round trip changes no bit.
        let sum = if (sum - 1.0).abs() < 1e-12 { 1.0 } else { sum };
        let mut entries: Vec<SkinWeight> = positive
            .map(|&(old, weight)| SkinWeight {
                bone: tree.index_of(old as usize),
                weight: weight / sum,
            })
            .collect();
        entries.sort_by_key(|w| w.bone);
        rows.push(entries);
    }
    Ok(rows)
}

/// The bones that the columns of `weights` are of, where each vertex has few.
const WEIGHT_BONES: &str = "weight_bones";

/// Weights of the bones that `weight_bones` names, both vertices × any; what a vertex names twice adds up.
fn named_weights(
    arrays: &Arrays,
    key: &str,
    [vertices, bones]: [usize; 2],
) -> Result<Rows<(u32, f64)>> {
    let named = arrays.expect(WEIGHT_BONES, &[Some(vertices), None])?;
    let columns = named.shape[1];
    let weights = arrays.expect(key, &[Some(vertices), Some(columns)])?;
    let is_bone = |b: &f64| (0.0..bones as f64).contains(b) && b.fract() == 0.0;
    let both = || named.numbers.iter().zip(&weights.numbers);
    // Unused columns often hold −1.
    if let Some(at) = both().position(|(b, w)| *w != 0.0 && !is_bone(b)) {
        let (v, bone) = (at / columns, named.numbers[at]);
        let problem = format!("vertex {v} names bone {bone} of {bones}");
        return Err(arrays.broken(WEIGHT_BONES, problem));
    }
    let mut used = both().map(|(b, w)| (*b as u32, *w));
    let rows = (0..vertices).map(|_| {
        let row: Vec<_> = used.by_ref().take(columns).collect();
        summed(&row)
    });
    Ok(rows.collect())
}

/// By `J_regressor`; else by `joints` (bones × 3) and the optional `joint_directions` (bones × 3 × `shapes`).
pub(super) fn joints(
    arrays: &Arrays,
    vertices: usize,
    tree: &Tree,
    shapes: usize,
) -> Result<Joints> {
    const KEYS: [&str; 2] = ["J_regressor", "joints"];
    const DIRECTIONS: &str = "joint_directions";
    if arrays.called(KEYS) == KEYS[0] {
        return joint_regressor(arrays, vertices, tree).map(Joints::Regressor);
    }
    let bones = tree.order.len();
    let in_order = |points: Vec<DVec3>| tree.order.iter().map(|&old| points[old]).collect();
    let template = arrays.expect(KEYS[1], &[Some(bones), Some(3)])?;
    let directions = directions(arrays, DIRECTIONS, bones)?;
    if shapes > 0 && directions.len() != shapes {
        let problem = format!(
            "{} are there for {shapes} shapes, which must move the joints too: give as many, or J_regressor (bones × \
             vertices) in place of joints",
            directions.len()
        );
        return Err(arrays.broken(DIRECTIONS, problem));
    }
    Ok(Joints::Given {
        template: in_order(vectors(template)),
        directions: directions.into_iter().map(in_order).collect(),
    })
}

fn joint_regressor(arrays: &Arrays, vertices: usize, tree: &Tree) -> Result<Rows<(u32, f64)>> {
    const KEY: &str = "J_regressor";
    let rows = arrays.nonzero_rows(KEY, [tree.order.len(), vertices])?;
    for (j, row) in rows.iter().enumerate() {
        let sum: f64 = row.iter().map(|entry| entry.1).sum();
        if (sum - 1.0).abs() > SUM_TOLERANCE {
            return Err(arrays.broken(KEY, format!("joint {j}: shares sum to {sum}, not to 1")));
        }
    }
    let row = |&old: &usize| rows.row(old).to_vec();
    Ok(tree.order.iter().map(row).collect())
}

/// The file's own names, else the published ones.
pub(super) fn names(arrays: &Arrays, kind: SmplKind, tree: &Tree) -> Result<Vec<String>> {
    let key = arrays.called(NAMES);
    let bones = tree.order.len();
    let names = match arrays.get(key)? {
        None => published::of(kind, bones),
        Some(array) => {
            let mut unique = array.texts.clone();
            unique.sort();
            unique.dedup();
            if array.texts.len() != bones || unique.len() != bones {
                return Err(arrays.broken(key, format!("{bones} different texts are needed")));
            }
            array.texts.clone()
        }
    };
    Ok(tree.order.iter().map(|&old| names[old].clone()).collect())
}
