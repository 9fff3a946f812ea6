//! The choice of the parts that are tissue.

use super::surface_parts::Part;
use glam::DVec3;
use std::collections::{BTreeSet, HashSet};
use supple::internal::math::Random;
use supple::model::{Skeleton, Surface};
use supple_bake::Body;
use supple_bake::math::winding_number;

/// Score of further tissue relative to the first's, and of the first relative to the largest of all.
const LEAST_SCORE: f64 = 0.02;

/// Gap between a part on neighbouring bones and the tissue, relative to the first part's extent.
const MOST_GAP: f64 = 0.1;

/// Which parts are tissue. `named` has what a recipe says of each: that it is tissue, or that it is not.
pub(super) fn choose_tissue(body: &Body, parts: &[Part], named: &[Option<bool>]) -> Vec<bool> {
    let skin = &body.skin;
    let may_be = |p: &usize| named[*p] != Some(false);
    // Hair is no tissue, however large and closed.
    let of_body = |p: &usize| named[*p] == Some(true) || !swings(body, &parts[*p]);
    let mut order: Vec<usize> = (0..parts.len()).filter(may_be).filter(of_body).collect();
    if order.is_empty() {
        order = (0..parts.len()).filter(may_be).collect();
    }
    let size = |p: usize| (parts[p].score(), parts[p].area);
    order.sort_by(|&a, &b| {
        let ((score_a, area_a), (score_b, area_b)) = (size(a), size(b));
        (score_b.total_cmp(&score_a)).then(area_b.total_cmp(&area_a))
    });
    let mut tissue = vec![false; parts.len()];
    let Some(first) = first_part(parts, &order) else {
        return tissue;
    };
    let mut grown = Grown::new(body, parts);
    let extent = parts[first].size(skin).max_element();
    for p in (order.iter().copied()).filter(|&p| p == first || named[p] == Some(true)) {
        tissue[p] = true;
        grown.add(&parts[p], skin);
    }
    let persons: BTreeSet<u32> = body
        .skeleton
        .aliases
        .iter()
        .map(|(_, bone)| *bone)
        .collect();
    let mut waiting: Vec<usize> = (order.into_iter())
        .filter(|&p| !tissue[p] && !parts[p].is_on_one_bone() && parts[p].score() > 0.0)
        .filter(|&p| parts[p].score() >= LEAST_SCORE * parts[first].score())
        .collect();
    // The largest that joins, again and again: what it brings may let a larger one join.
    let joins = |grown: &Grown<'_>, part: &Part| {
        let is_limb = persons.is_empty() || part.weights.keys().any(|b| persons.contains(b));
        let next_to = |grown: &Grown<'_>| {
            part.weights.keys().any(|b| grown.next_to.contains(b))
                && grown.gap(part, skin) <= MOST_GAP * extent
        };
        part.weights.keys().any(|b| grown.bones.contains(b)) || is_limb && next_to(grown)
    };
    while let Some(at) = waiting.iter().position(|&p| joins(&grown, &parts[p])) {
        let p = waiting.remove(at);
        // One that lies in the tissue now lies in it when there is more.
        if part_within(skin, &parts[p], &grown.triangles) < 0.5 {
            tissue[p] = true;
            grown.add(&parts[p], skin);
        }
    }
    tissue
}

/// Whether spring bones, but those that the file calls a person's, move most of a part.
fn swings(body: &Body, part: &Part) -> bool {
    let persons = |bone: u32| body.skeleton.aliases.iter().any(|(_, b)| *b == bone);
    let swings = |bone: u32| body.springs.of_bone(bone as usize).is_some() && !persons(bone);
    !body.springs.is_empty() && part.share(swings) > 0.5
}

/// The first of `order` that several bones move and that is no trinket: in score, or by the largest area. A helmet or a ball of
/// hair may be larger than the body. Where there is none, the first.
fn first_part(parts: &[Part], order: &[usize]) -> Option<usize> {
    let largest = parts[*order.first()?].score();
    let area = |p: &usize| parts[*p].area;
    let widest = (order.iter().copied()).max_by(|a, b| area(a).total_cmp(&area(b)));
    let counts = |p: &usize| {
        let score = parts[*p].score();
        score > 0.0 && score >= LEAST_SCORE * largest || Some(*p) == widest
    };
    let several = |p: &usize| !parts[*p].is_on_one_bone();
    let first = order.iter().find(|p| several(p) && counts(p));
    first.or(order.first()).copied()
}

/// The tissue as it grows.
struct Grown<'a> {
    skeleton: &'a Skeleton,
    /// Which bones move any part.
    weighted: Vec<bool>,
    triangles: Vec<[u32; 3]>,
    low: DVec3,
    high: DVec3,
    /// The bones that move it.
    bones: HashSet<u32>,
    /// Those, and the bones that no other bone with weight parts from them.
    next_to: HashSet<u32>,
}

impl<'a> Grown<'a> {
    fn new(body: &'a Body, parts: &[Part]) -> Self {
        let mut weighted = vec![false; body.skeleton.len()];
        for bone in parts.iter().flat_map(|p| p.weights.keys()) {
            weighted[*bone as usize] = true;
        }
        Self {
            skeleton: &body.skeleton,
            weighted,
            triangles: Vec::new(),
            low: DVec3::INFINITY,
            high: DVec3::NEG_INFINITY,
            bones: HashSet::new(),
            next_to: HashSet::new(),
        }
    }

    fn add(&mut self, part: &Part, skin: &Surface) {
        self.triangles.extend(&part.triangles);
        let (low, high) = part.bounds(skin);
        (self.low, self.high) = (self.low.min(low), self.high.max(high));
        self.bones.extend(part.weights.keys());
        let parents = &self.skeleton.parents;
        let mut children = vec![Vec::new(); parents.len()];
        for (j, parent) in parents.iter().enumerate() {
            if let Some(p) = parent {
                children[*p as usize].push(j as u32);
            }
        }
        // From bone to bone as far as the first with weight: a shoulder without any parts no arm from its chest.
        self.next_to.clone_from(&self.bones);
        let mut open: Vec<u32> = self.bones.iter().copied().collect();
        while let Some(bone) = open.pop() {
            let near = (children[bone as usize].iter().copied()).chain(parents[bone as usize]);
            for b in near {
                if self.next_to.insert(b) && !self.weighted[b as usize] {
                    open.push(b);
                }
            }
        }
    }

    /// How far the box around a part is from that around the tissue, m.
    fn gap(&self, part: &Part, skin: &Surface) -> f64 {
        let (low, high) = part.bounds(skin);
        (low - self.high)
            .max(self.low - high)
            .max(DVec3::ZERO)
            .length()
    }
}

/// The share of a part's volume that `others` hold, from points strewn in it by a fixed seed.
fn part_within(skin: &Surface, part: &Part, others: &[[u32; 3]]) -> f64 {
    const TRIES: usize = 400;
    const ENOUGH: usize = 40;
    let corners = |t: &[u32; 3]| t.map(|v| skin.positions[v as usize]);
    let inside = |p: DVec3, triangles: &[[u32; 3]]| {
        winding_number(p, triangles.iter().map(corners)).abs() > 0.5
    };
    let (low, high) = part.bounds(skin);
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
