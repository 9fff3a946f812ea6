//! How deep the soft layer of a shell is under each vertex of the skin.
//!
//! min(thickness, ½ local radius, room above the bones), where the local radius is that of the largest
//! ball inside the skin that touches it there; then smoothed over the skin. A recipe may paint it or set it
//! for single bones; such values are kept as far as the local radius allows.

use super::bone_axes::{BoneAxis, extent};
use super::sound_skin::SoundSkin;
use super::thin_spots::close_thin_spots;
use crate::body::Body;
use crate::math::Blocks;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use supple::internal::math::{Rows, par_map};
use supple::model::{Skeleton, SkinWeight, Surface};
use supple::{Error, Result};

/// How a shell is made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ShellOptions {
    /// Greatest depth of the layer, m; by default 4 % of the skin's largest extent, 0.6 % on a head (a bone so
    /// named, or where there is none the last of several that are named neck, and those that hang on it).
    pub thickness: Option<f64>,
    /// Depth under the skin that follows a bone, by the bone's name, m.
    pub thickness_of_bone: BTreeMap<String, f64>,
    /// A map painted on the skin ([`Body::painted`]): the depth is `thickness` times its value.
    pub painted_thickness: Option<String>,
    /// Number of prism layers, 1 to 16; by default as many, of 1 to 3, as make 50,000 tets.
    pub layers: Option<usize>,
}

/// Greatest depth by default, relative to the skin's largest extent.
const THICKNESS: f64 = 0.04;

/// Tets that an automatic number of layers aims at, and how many layers it takes at most.
const TETS: usize = 50_000;
const MOST_LAYERS: usize = 3;

/// The same on a head and what hangs on it, where the skull lies right below.
const ON_HEADS: f64 = 0.006;

/// Greatest depth relative to the local radius.
const OF_RADIUS: f64 = 0.5;

/// The same where the recipe sets the depth.
const OF_RADIUS_AS_TOLD: f64 = 0.8;

/// Depth that bones leave in any case, relative to the local radius.
const OVER_BONES: f64 = 0.15;

/// Cosine between two normals that face away from each other.
const FACING_AWAY: f64 = -0.17;

/// Greatest change of depth along an edge, relative to its length.
const SLOPE: f64 = 0.5;

/// Rounds of averaging over the neighbours.
const SMOOTHING: usize = 10;

impl ShellOptions {
    /// Checks the numbers, and the names against `body`.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the key.
    pub fn validate(&self, body: &Body) -> Result<()> {
        let positive = |value: f64| value > 0.0 && value.is_finite();
        if self.thickness.is_some_and(|t| !positive(t)) {
            return Err(Error::invalid(
                "recipe.mesher.thickness",
                "must be positive (m)",
            ));
        }
        if self.layers.is_some_and(|n| !(1..=16).contains(&n)) {
            return Err(Error::invalid("recipe.mesher.layers", "must be 1 to 16"));
        }
        for (name, value) in &self.thickness_of_bone {
            let field = format!("recipe.mesher.thickness_of_bone.{name}");
            if !(*value >= 0.0 && value.is_finite()) {
                return Err(Error::invalid(field, "must be zero or positive (m)"));
            }
            if body.skeleton.find(name).is_none() {
                let bones = body.skeleton.names.join(", ");
                return Err(Error::invalid(
                    field,
                    format!("no such bone; there are {bones}"),
                ));
            }
        }
        match &self.painted_thickness {
            Some(name) if !body.painted.contains_key(name) => {
                let maps: Vec<&str> = body.painted.keys().map(String::as_str).collect();
                let problem = format!("no such map is painted; there are [{}]", maps.join(", "));
                Err(Error::invalid("recipe.mesher.painted_thickness", problem))
            }
            _ => Ok(()),
        }
    }

    /// Layers for a skin of so many triangles.
    pub(crate) fn layers_for(&self, triangles: usize) -> usize {
        let automatic = (TETS / (3 * triangles).max(1)).clamp(1, MOST_LAYERS);
        self.layers.unwrap_or(automatic)
    }
}

/// Depth of the layer under each vertex of `body`'s skin, m.
pub(crate) fn thickness(
    body: &Body,
    sound: &SoundSkin,
    axes: &[BoneAxis],
    options: &ShellOptions,
) -> Vec<f64> {
    let skin = sound.skin();
    let most = options.thickness.unwrap_or(THICKNESS * extent(&skin));
    let radius = local_radius(&skin, &skin.vertex_normals());
    let painted = (options.painted_thickness.as_ref()).and_then(|name| body.painted.get(name));
    let of_bone: BTreeMap<u32, f64> = (options.thickness_of_bone.iter())
        .filter_map(|(name, &value)| Some((body.skeleton.find(name)? as u32, value)))
        .collect();
    let on_head = match options.thickness {
        None => share_of_bones(&body.skinning, &head_bones(&body.skeleton)),
        Some(_) => vec![0.0; radius.len()],
    };
    let automatic = par_map(radius.len(), |v| {
        // A head that carries a little of its neck's weights is a head.
        let head = on_head[v] * on_head[v] * (3.0 - 2.0 * on_head[v]);
        let most = most * (1.0 - head * (1.0 - ON_HEADS / THICKNESS));
        let room = (axes.iter().map(|axis| axis.distance(skin.positions[v])))
            .fold(f64::INFINITY, f64::min)
            .max(OVER_BONES * radius[v]);
        most.min(OF_RADIUS * radius[v]).min(room)
    });
    let mut depth: Vec<f64> = (automatic.into_iter().enumerate())
        .map(|(v, automatic)| {
            let limit = OF_RADIUS_AS_TOLD * radius[v];
            let base = painted.map_or(automatic, |map| (most * map[v].max(0.0)).min(limit));
            let (told, weight) = (body.skinning.row(v).iter())
                .filter_map(|w| Some((w.weight * of_bone.get(&w.bone)?, w.weight)))
                .fold((0.0, 0.0), |sum, x| (sum.0 + x.0, sum.1 + x.1));
            (told + (1.0 - weight).max(0.0) * base).min(limit)
        })
        .collect();
    let around = neighbours(&skin);
    close_thin_spots(&skin, &around, &mut depth);
    limit_slope(&skin, &mut depth, SLOPE);
    smooth(&around, &mut depth);
    limit_slope(&skin, &mut depth, SLOPE);
    depth
}

/// Radius of the largest ball that touches the skin at each vertex from inside, m: the least
/// |p − q|² / (2 n·(p − q)) over the vertices q that face away (by 100° or more: a breast or a belly is as
/// deep as the body behind it, and not as its own curvature). No more than the skin's extent.
fn local_radius(skin: &Surface, normals: &[DVec3]) -> Vec<f64> {
    let most = extent(skin);
    let blocks = Blocks::new(&skin.positions);
    par_map(skin.positions.len(), |v| {
        let (p, n) = (skin.positions[v], normals[v]);
        let mut radius = most;
        for (block, members) in blocks.iter() {
            // What lies outside the ball so far would touch a larger one.
            let reach = radius * (1.0 + 1e-9);
            if block.distance_squared(p - radius * n) > reach * reach {
                continue;
            }
            for &q in members {
                let offset = p - skin.positions[q as usize];
                let height = n.dot(offset);
                if n.dot(normals[q as usize]) < FACING_AWAY && height > 0.0 {
                    radius = radius.min(offset.length_squared() / (2.0 * height));
                }
            }
        }
        radius
    })
}

/// Bones that are called head, or where none is the last ones that are called neck; and all that hang on them.
fn head_bones(skeleton: &Skeleton) -> Vec<bool> {
    let called = |what: &str| {
        let mut found: Vec<bool> = (skeleton.names.iter())
            .map(|name| name.to_lowercase().contains(what))
            .collect();
        for (alias, bone) in &skeleton.aliases {
            found[*bone as usize] |= alias.to_lowercase().contains(what);
        }
        found
    };
    let mut heads = called("head");
    if !heads.contains(&true) {
        heads = called("neck");
        for (j, parent) in skeleton.parents.iter().enumerate() {
            if let Some(p) = parent.filter(|_| heads[j]) {
                heads[p as usize] = false;
            }
        }
        // The only bone of a neck carries the neck as well.
        for (j, parent) in skeleton.parents.iter().enumerate() {
            let of_neck = |p: &u32| skeleton.names[*p as usize].to_lowercase().contains("neck");
            heads[j] &= parent.as_ref().is_some_and(of_neck);
        }
    }
    for (j, parent) in skeleton.parents.iter().enumerate() {
        heads[j] |= parent.is_some_and(|p| heads[p as usize]);
    }
    heads
}

/// The part of each vertex' weight that is on `chosen` bones.
fn share_of_bones(skinning: &Rows<SkinWeight>, chosen: &[bool]) -> Vec<f64> {
    let share = |row: &[SkinWeight]| {
        let on_chosen = row.iter().filter(|w| chosen[w.bone as usize]);
        on_chosen.map(|w| w.weight).sum::<f64>().clamp(0.0, 1.0)
    };
    skinning.iter().map(share).collect()
}

/// Lowers `depth` until it changes by `slope` times their length at most along edges.
pub(super) fn limit_slope(skin: &Surface, depth: &mut [f64], slope: f64) {
    let mut changed = true;
    // Each sweep settles at least one vertex more.
    while changed {
        changed = false;
        for &[a, b, c] in &skin.triangles {
            for (u, v) in [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)] {
                let (u, v) = (u as usize, v as usize);
                let reach = slope * (skin.positions[u] - skin.positions[v]).length();
                // Rounding must not keep it going.
                if depth[u] > (depth[v] + reach) * (1.0 + 1e-12) {
                    depth[u] = depth[v] + reach;
                    changed = true;
                }
            }
        }
    }
}

/// Averages over neighbours, which evens out what single vertices miss.
fn smooth(around: &Rows<u32>, depth: &mut Vec<f64>) {
    for _ in 0..SMOOTHING {
        *depth = (around.iter().zip(&*depth))
            .map(|(row, &own)| match row {
                [] => own,
                _ => {
                    let sum: f64 = row.iter().map(|&v| depth[v as usize]).sum();
                    0.5 * (own + sum / row.len() as f64)
                }
            })
            .collect();
    }
}

/// The vertices that share an edge with each vertex, rising.
pub(crate) fn neighbours(skin: &Surface) -> Rows<u32> {
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); skin.positions.len()];
    for &[a, b, c] in &skin.triangles {
        for (u, v) in [(a, b), (b, c), (c, a)] {
            around[u as usize].push(v);
            around[v as usize].push(u);
        }
    }
    for row in &mut around {
        row.sort_unstable();
        row.dedup();
    }
    around.into_iter().collect()
}
