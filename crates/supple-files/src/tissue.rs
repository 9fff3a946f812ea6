//! Which of a character's surfaces bound its tissue, and what hangs on it.
//!
//! Surfaces are the connected parts of the welded skin. The tissue is the part with the largest *score*,
//!
//! score = |enclosed volume| · max(0, 1 − 4 · holes' share of the area),
//!
//! holes being closed by cones for both: a body with open eye sockets keeps its volume, a coat that is
//! open below loses it. Where every score is 0, it is the part with the largest area. Further parts are
//! tissue too (a head, a hand made apart) if their score is at least 2 % of the largest, they are moved by
//! several bones of which one moves tissue, and less than half of their volume lies in tissue already.
//!
//! Everything else is attached. It *follows the nearest tissue*, less and less with its distance
//! ([`supple_bake`]), except what stays *rigid*, moved by its bones alone: parts whose bones move no tissue
//! (hair with bones of its own), and nearly closed parts on one bone (eyes, teeth, shoes, props).

use super::surface_parts::{Part, connected_parts};
use glam::DVec3;
use std::collections::{BTreeMap, HashSet};
use supple::internal::math::{Random, Rows};
use supple::model::{PoseBlend, SkinWeight, Surface};
use supple_bake::math::winding_number;
use supple_bake::{Attachment, Body};

/// Score of further tissue relative to the first's.
const LEAST_SCORE: f64 = 0.02;

/// The body with only its tissue's surface as skin; the other parts of its skin are attachments,
/// after those that it has.
pub fn separate_tissue(body: Body) -> Body {
    let (part_of, parts) = connected_parts(&body.skin, &body.skinning);
    let tissue = choose_tissue(&body.skin, &parts);
    if tissue.iter().all(|t| *t) && part_of.iter().all(Option::is_some) {
        return body;
    }
    let mut carries_tissue: HashSet<u32> = HashSet::new();
    for (part, _) in parts.iter().zip(&tissue).filter(|(_, t)| **t) {
        carries_tissue.extend(part.weights.keys());
    }
    let follows = |part: &Part| {
        let rigid = part.is_on_one_bone() && part.score() > 0.0;
        !rigid && part.share(|bone| carries_tissue.contains(&bone)) > 0.5
    };
    let names = part_names(&body, &part_of, parts.len());
    // Attachments by name and whether they follow, in the order of their first part. Vertices of no
    // triangle are one more.
    let mut groups: Vec<(String, bool)> = Vec::new();
    let mut group_of: Vec<Option<usize>> = Vec::new();
    for (p, part) in parts.iter().enumerate() {
        let key = (names[p].clone(), follows(part));
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
    split(&body, groups.clone(), group)
}

/// Which parts are tissue.
fn choose_tissue(skin: &Surface, parts: &[Part]) -> Vec<bool> {
    let mut tissue = vec![false; parts.len()];
    let mut order: Vec<usize> = (0..parts.len()).collect();
    let size = |p: &usize| (parts[*p].score(), parts[*p].area);
    order.sort_by(|a, b| {
        let ((score_a, area_a), (score_b, area_b)) = (size(a), size(b));
        (score_b.total_cmp(&score_a)).then(area_b.total_cmp(&area_a))
    });
    let Some((&first, others)) = order.split_first() else {
        return tissue;
    };
    tissue[first] = true;
    let mut bones: HashSet<u32> = parts[first].weights.keys().copied().collect();
    let mut accepted = parts[first].triangles.clone();
    for &p in others {
        let part = &parts[p];
        if part.score() < LEAST_SCORE * parts[first].score() || part.score() == 0.0 {
            break;
        }
        let joined = part.weights.keys().any(|b| bones.contains(b));
        if joined && !part.is_on_one_bone() && part_within(skin, part, &accepted) < 0.5 {
            tissue[p] = true;
            bones.extend(part.weights.keys());
            accepted.extend(&part.triangles);
        }
    }
    tissue
}

/// The share of a part's volume that `others` hold, from points strewn in it by a fixed seed.
fn part_within(skin: &Surface, part: &Part, others: &[[u32; 3]]) -> f64 {
    const TRIES: usize = 400;
    const ENOUGH: usize = 40;
    let corners = |t: &[u32; 3]| t.map(|v| skin.positions[v as usize]);
    let inside = |p: DVec3, triangles: &[[u32; 3]]| {
        winding_number(p, triangles.iter().map(corners)).abs() > 0.5
    };
    let (low, high) = (part.triangles.iter().flat_map(corners))
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
            (low.min(p), high.max(p))
        });
    let mut random = Random::new(1);
    let (mut own, mut both) = (0, 0);
    for _ in 0..TRIES {
        let share = DVec3::from_array([0; 3].map(|_| random.uniform(0.0, 1.0)));
        let p = low + share * (high - low);
        if inside(p, &part.triangles) {
            own += 1;
            both += usize::from(inside(p, others));
        }
        if own == ENOUGH {
            break;
        }
    }
    f64::from(both as u32) / f64::from(own.max(1) as u32)
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
