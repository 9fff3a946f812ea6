//! The connected parts of a surface, and what each encloses.

use glam::DVec3;
use std::collections::{BTreeMap, HashSet};
use supple::internal::math::Rows;
use supple::model::{SkinWeight, Surface};
use supple_bake::mesh::DisjointSets;

/// A part whose holes have this share of its area encloses nothing.
const MOST_OPEN: f64 = 0.25;

/// Weight on its largest bone above which a part counts as moved by one bone.
const ONE_BONE: f64 = 0.99;

/// A connected part of a surface.
#[derive(Debug, Default)]
pub(super) struct Part {
    pub triangles: Vec<[u32; 3]>,
    pub area: f64,
    hole_area: f64,
    volume: f64,
    /// Σ of its vertices' weights of each bone.
    pub weights: BTreeMap<u32, f64>,
}

impl Part {
    fn openness(&self) -> f64 {
        self.hole_area / (self.area + self.hole_area).max(f64::MIN_POSITIVE)
    }

    /// |volume| · max(0, 1 − 4 · holes' share of the area), m³.
    pub fn score(&self) -> f64 {
        self.volume.abs() * (1.0 - self.openness() / MOST_OPEN).max(0.0)
    }

    /// The share of its weight that `bones` carry.
    pub fn share(&self, is_one: impl Fn(u32) -> bool) -> f64 {
        let total: f64 = self.weights.values().sum();
        let carried = self.weights.iter().filter(|(bone, _)| is_one(**bone));
        carried.map(|(_, w)| w).sum::<f64>() / total.max(f64::MIN_POSITIVE)
    }

    /// Lowest and highest corner of the box around it, m.
    pub fn bounds(&self, skin: &Surface) -> (DVec3, DVec3) {
        let corners = self.triangles.iter().flatten();
        corners
            .map(|&v| skin.positions[v as usize])
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
                (low.min(p), high.max(p))
            })
    }

    /// Size of that box, m.
    pub fn size(&self, skin: &Surface) -> DVec3 {
        let (low, high) = self.bounds(skin);
        high - low
    }

    pub fn is_on_one_bone(&self) -> bool {
        self.weights
            .keys()
            .any(|b| self.share(|bone| bone == *b) > ONE_BONE)
    }
}

/// The part of each vertex that a triangle uses, and the parts, in the order of their first vertices.
pub(super) fn connected_parts(
    skin: &Surface,
    skinning: &Rows<SkinWeight>,
) -> (Vec<Option<u32>>, Vec<Part>) {
    let mut sets = DisjointSets::new(skin.positions.len());
    let mut used = vec![false; skin.positions.len()];
    for &[a, b, c] in &skin.triangles {
        sets.union(a, b);
        sets.union(b, c);
        for v in [a, b, c] {
            used[v as usize] = true;
        }
    }
    let mut part_of = vec![None; used.len()];
    let mut parts: Vec<Part> = Vec::new();
    for v in (0..used.len()).filter(|&v| used[v]) {
        // The smallest member comes first.
        let first = sets.find(v as u32) as usize;
        if first == v {
            parts.push(Part::default());
            part_of[v] = Some(parts.len() as u32 - 1);
        }
        part_of[v] = part_of[first];
        let part = part_of[v].map_or(0, |p| p as usize);
        for w in skinning.row(v) {
            *parts[part].weights.entry(w.bone).or_default() += w.weight;
        }
    }
    for t in &skin.triangles {
        if let Some(p) = part_of[t[0] as usize] {
            parts[p as usize].triangles.push(*t);
        }
    }
    parts.iter_mut().for_each(|p| p.measure(&skin.positions));
    (part_of, parts)
}

impl Part {
    /// Area and volume, each hole closed by a cone over the middle of its rim.
    fn measure(&mut self, positions: &[DVec3]) {
        let place = |v: u32| positions[v as usize];
        // From a point nearby, so that a part far from the origin loses no digits.
        let origin = place(self.triangles[0][0]);
        let spans = |[a, b, c]: [DVec3; 3]| {
            let area = 0.5 * (b - a).cross(c - a).length();
            let [a, b, c] = [a, b, c].map(|p| p - origin);
            (area, a.dot(b.cross(c)) / 6.0)
        };
        for t in &self.triangles {
            let (area, volume) = spans(t.map(place));
            self.area += area;
            self.volume += volume;
        }
        for rim in rims(&self.triangles) {
            let middle = rim.iter().map(|e| place(e[0])).sum::<DVec3>() / rim.len() as f64;
            for [a, b] in rim {
                let (area, volume) = spans([place(b), place(a), middle]);
                self.hole_area += area;
                self.volume += volume;
            }
        }
    }
}

/// The directed edges without an opposite one, those that hang together in one list.
fn rims(triangles: &[[u32; 3]]) -> Vec<Vec<[u32; 2]>> {
    let edges = |&[a, b, c]: &[u32; 3]| [[a, b], [b, c], [c, a]];
    let all: HashSet<[u32; 2]> = triangles.iter().flat_map(edges).collect();
    let open: Vec<[u32; 2]> = (triangles.iter().flat_map(edges))
        .filter(|[a, b]| !all.contains(&[*b, *a]))
        .collect();
    let mut number: BTreeMap<u32, u32> = BTreeMap::new();
    for v in open.iter().flatten() {
        let next = number.len() as u32;
        number.entry(*v).or_insert(next);
    }
    let mut sets = DisjointSets::new(number.len());
    open.iter()
        .for_each(|[a, b]| sets.union(number[a], number[b]));
    let mut rims: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
    for edge in open {
        rims.entry(sets.find(number[&edge[0]]))
            .or_default()
            .push(edge);
    }
    rims.into_values().collect()
}
