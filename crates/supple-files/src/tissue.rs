//! Which of a character's surfaces bound its tissue, and what hangs on it.
//!
//! Surfaces are the connected parts of the welded skin. Each has a *score*,
//!
//! score = |enclosed volume| · max(0, 1 − 4 · holes' share of the area),
//!
//! holes being closed by cones for both: a body with open eye sockets keeps its volume, a coat that is
//! open below loses it. The tissue starts from the best part that several bones move (a helmet on one bone may
//! be larger), or where there is none from the best of all; where every score is 0, the largest area is the best.
//! Parts join it (a head, a limb made apart), the largest first and as long as any does, if their score is at
//! least 2 % of the first's, several bones move them, less than half of their volume lies in tissue already,
//! and one of their bones moves tissue or is next to one that does, no other bone with weight between. Of those
//! that are merely next to it, boxes are apart by a tenth of the first's extent at most, and where the file says
//! which bones are a person's (VRM), one of these moves them: hair does not join, nor does what spring bones move mostly.
//!
//! Everything else is attached. It *follows the nearest tissue*, less and less with its distance
//! ([`supple_bake`]), except what stays *rigid*, moved by its bones alone: parts whose bones move no tissue
//! (hair with bones of its own), and nearly closed parts on one bone (eyes, teeth, shoes, props).
//!
//! [`PartNames`] are exceptions from this.

use super::surface_parts::{Part, connected_parts};
use super::tissue_choice::choose_tissue;
use std::collections::{BTreeMap, BTreeSet, HashSet};
use supple::internal::math::Rows;
use supple::model::{PoseBlend, SkinWeight, Surface};
use supple::{Error, Result};
use supple_bake::{Attachment, Body};

/// Parts by name, against what is chosen. A part has the name of the file's mesh that draws most of it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PartNames {
    /// Parts that are tissue besides those that are chosen; others join these too.
    pub tissue: Vec<String>,
    /// Parts that are attached, and that their bones alone move.
    pub rigid: Vec<String>,
}

impl PartNames {
    /// Whether nothing is named.
    pub fn is_empty(&self) -> bool {
        self.tissue.is_empty() && self.rigid.is_empty()
    }

    /// What is said of each part: that it is tissue, or that it is rigid.
    fn roles(&self, parts: &[String]) -> Result<Vec<Option<bool>>> {
        let mut roles = vec![None; parts.len()];
        for (list, key, role) in [
            (&self.tissue, "tissue", true),
            (&self.rigid, "rigid", false),
        ] {
            for (i, name) in list.iter().enumerate() {
                let wrong = |problem| Err(Error::invalid(format!("{key}[{i}]"), problem));
                let mut found = false;
                for (slot, _) in roles.iter_mut().zip(parts).filter(|(_, n)| *n == name) {
                    if slot.is_some_and(|before| before != role) {
                        return wrong(format!("{name:?} is in both lists: leave it in one"));
                    }
                    (*slot, found) = (Some(role), true);
                }
                if !found {
                    return wrong(format!(
                        "no part is called {name:?}; there are {}",
                        told(parts)
                    ));
                }
            }
        }
        Ok(roles)
    }
}

/// Names, each once and not too many.
fn told(names: &[String]) -> String {
    const MOST: usize = 24;
    let names: BTreeSet<&str> = names.iter().map(String::as_str).collect();
    let mut text = (names.iter().take(MOST).copied())
        .collect::<Vec<_>>()
        .join(", ");
    if names.len() > MOST {
        text += &format!(" and {} more", names.len() - MOST);
    }
    text
}

/// The body with only its tissue's surface as skin; the other parts of its skin are attachments,
/// after those that it has.
///
/// # Errors
/// [`Error::Invalid`] naming an entry of `named` that names no part or one of the other list, or a list that leaves no tissue.
pub fn separate_tissue(body: Body, named: &PartNames) -> Result<Body> {
    let (part_of, parts) = connected_parts(&body.skin, &body.skinning);
    let names = part_names(&body, &part_of, parts.len());
    let roles = named.roles(&names)?;
    let tissue = choose_tissue(&body, &parts, &roles);
    if tissue.iter().all(|t| *t) && part_of.iter().all(Option::is_some) {
        return Ok(body);
    }
    if !parts.is_empty() && !tissue.contains(&true) {
        let problem = "names every part: leave one out, which is then tissue";
        return Err(Error::invalid("rigid", problem));
    }
    let mut carries_tissue: HashSet<u32> = HashSet::new();
    for (part, _) in parts.iter().zip(&tissue).filter(|(_, t)| **t) {
        carries_tissue.extend(part.weights.keys());
    }
    let follows = |part: &Part| {
        let rigid = part.is_on_one_bone() && part.score() > 0.0;
        !rigid && part.share(|bone| carries_tissue.contains(&bone)) > 0.5
    };
    // Attachments by name and whether they follow, in the order of their first part. Vertices of no
    // triangle are one more.
    let mut groups: Vec<(String, bool)> = Vec::new();
    let mut group_of: Vec<Option<usize>> = Vec::new();
    for (p, part) in parts.iter().enumerate() {
        let key = (names[p].clone(), roles[p].is_none() && follows(part));
        group_of.push(
            (!tissue[p]).then(|| match groups.iter().position(|g| *g == key) {
                Some(at) => at,
                None => {
                    groups.push(key);
                    groups.len() - 1
                }
            }),
        );
    }
    let loose = part_of.iter().any(Option::is_none).then(|| {
        groups.push(("vertices without triangles".into(), true));
        groups.len() - 1
    });
    let group = |v: usize| part_of[v].map_or(loose, |p| group_of[p as usize]);
    Ok(split(&body, groups.clone(), group))
}

/// A name for each part: that of what draws most of its triangles.
fn part_names(body: &Body, part_of: &[Option<u32>], parts: usize) -> Vec<String> {
    let mut drawn: Vec<BTreeMap<usize, usize>> = vec![BTreeMap::new(); parts];
    for (d, part) in body.render_meshes.iter().enumerate() {
        for v in part.triangles.iter().map(|t| part.vertices[t[0] as usize]) {
            if let Some(p) = part_of.get(v as usize).copied().flatten() {
                *drawn[p as usize].entry(d).or_default() += 1;
            }
        }
    }
    let name = |(p, counts): (usize, &BTreeMap<usize, usize>)| {
        let most = counts
            .iter()
            .max_by_key(|(d, count)| (**count, std::cmp::Reverse(**d)));
        most.map_or_else(
            || format!("surface {p}"),
            |(d, _)| body.render_meshes[*d].name.clone(),
        )
    };
    drawn.iter().enumerate().map(name).collect()
}

/// Moves each vertex with a group into that group's attachment.
fn split(body: &Body, groups: Vec<(String, bool)>, group: impl Fn(usize) -> Option<usize>) -> Body {
    let before = body.skin.positions.len();
    let mut skin = Vec::new();
    let mut members: Vec<Vec<u32>> = vec![Vec::new(); groups.len()];
    for v in 0..before {
        match group(v) {
            None => skin.push(v as u32),
            Some(g) => members[g].push(v as u32),
        }
    }
    // New numbers of the body's vertices: skin, earlier attachments, new ones.
    let earlier: usize = (body.attachments.iter())
        .map(|a| a.surface.positions.len())
        .sum();
    let shifted = (before..before + earlier).map(|v| v as u32);
    let order = skin
        .iter()
        .copied()
        .chain(shifted)
        .chain(members.iter().flatten().copied());
    let mut number = vec![0; before + earlier];
    for (new, old) in order.enumerate() {
        number[old as usize] = new as u32;
    }
    let surface = |members: &[u32]| {
        let first = members.first().map_or(0, |&v| number[v as usize]);
        let own = members.iter().map(|&v| number[v as usize] - first);
        let own: BTreeMap<u32, u32> = members.iter().copied().zip(own).collect();
        let triangles = body.skin.triangles.iter();
        Surface {
            positions: members
                .iter()
                .map(|&v| body.skin.positions[v as usize])
                .collect(),
            triangles: (triangles.filter(|t| own.contains_key(&t[0])))
                .map(|t| t.map(|v| own[&v]))
                .collect(),
        }
    };
    let rows = |members: &[u32]| -> Rows<SkinWeight> {
        let rows = members
            .iter()
            .map(|&v| body.skinning.row(v as usize).to_vec());
        rows.collect()
    };
    let blend = |members: &[u32]| PoseBlend {
        features: body.pose_blend.features,
        columns: (body.pose_blend.columns.chunks_exact(before.max(1)))
            .flat_map(|column| members.iter().map(|&v| column[v as usize]))
            .collect(),
    };
    let mut attachments = body.attachments.clone();
    for ((name, follows_tissue), members) in groups.into_iter().zip(&members) {
        attachments.push(Attachment {
            name,
            surface: surface(members),
            skinning: rows(members),
            pose_blend: blend(members),
            follows_tissue,
        });
    }
    let mut render_meshes = body.render_meshes.clone();
    for v in render_meshes.iter_mut().flat_map(|d| &mut d.vertices) {
        *v = number[*v as usize];
    }
    let paint = |values: &Vec<f64>| skin.iter().map(|&v| values[v as usize]).collect();
    Body {
        skin: surface(&skin),
        skinning: rows(&skin),
        pose_blend: blend(&skin),
        painted: (body.painted.iter())
            .map(|(name, values)| (name.clone(), paint(values)))
            .collect(),
        attachments,
        render_meshes,
        ..body.clone()
    }
}
