//! A skin made fit for meshing: every triangle once, all looking outward, holes closed by fans.
//!
//! Nothing here stops a mesher. What was found is in the [`SkinReport`].

use super::bone_axes::extent;
use super::disjoint_sets::DisjointSets;
use super::report::{Hole, SkinReport};
use super::self_intersections::self_intersections;
use crate::math::winding_number;
use crate::model::Surface;
use crate::{Error, Result};
use glam::DVec3;
use std::collections::{BTreeMap, HashMap, HashSet};

/// A skin whose triangles bound a solid: along any line the winding number starts and ends at 0.
pub(crate) struct SoundSkin {
    /// The skin's vertices, then one in the middle of each hole; the skin's triangles, then the fans.
    pub surface: Surface,
    /// How many of the triangles are the skin's own.
    pub skin_triangles: usize,
    /// For each vertex the one that stands for it: another one in the same place on the border of the same
    /// seam, or itself.
    pub stands_for: Vec<u32>,
    /// Vertices around holes and on non-manifold edges, which the bones hold.
    pub held: Vec<bool>,
    /// The vertices around each hole; hole `h` has vertex `vertices + h` in its middle.
    pub rims: Vec<Vec<u32>>,
    /// The skin's triangles as they came, but all looking outward.
    pub oriented: Vec<[u32; 3]>,
    /// What was found.
    pub report: SkinReport,
}

/// Vertices of a seam lie no farther apart than about this, relative to the skin's extent.
const SEAM: f64 = 1e-6;

/// A part that encloses less than this, relative to its area to the power of 3/2, is flat.
const FLAT: f64 = 1e-6;

/// A triangle thinner than this, relative to its longest edge squared, has no area.
const LEAST_AREA: f64 = 1e-9;

impl SoundSkin {
    /// Looks through `skin`, turns what looks inward and closes holes.
    ///
    /// # Errors
    /// [`Error::Invalid`] where a position is not finite, a triangle names a vertex that is not there, or
    /// there is no triangle at all.
    pub fn new(skin: &Surface) -> Result<Self> {
        let vertices = skin.positions.len();
        if !skin.positions.iter().all(|p| p.is_finite())
            || (skin.triangles.iter().flatten()).any(|&v| v as usize >= vertices)
        {
            let problem = "holds a value that is not finite, or names a vertex that is not there";
            return Err(Error::invalid("skin", problem));
        }
        let mut report = SkinReport {
            vertices,
            triangles: skin.triangles.len(),
            ..SkinReport::default()
        };
        let stands_for = stitch(skin, &mut report);
        let mut surface = Surface {
            positions: skin.positions.clone(),
            triangles: (skin.triangles.iter())
                .map(|t| t.map(|v| stands_for[v as usize]))
                .collect(),
        };
        let kept = distinct_triangles(&surface, &stands_for, &mut report);
        if kept.is_empty() {
            return Err(Error::invalid("skin", "has no triangle with area"));
        }
        let all = std::mem::take(&mut surface.triangles);
        surface.triangles = kept.iter().map(|&t| all[t]).collect();
        let mut held = vec![false; vertices];
        make_consistent(&mut surface);
        mark_non_manifold(&surface, &mut held, &mut report);
        let part = parts(&surface, &mut report);
        let skin_triangles = kept.len();
        let rims = close_holes(&mut surface, &mut held, &mut report);
        turn_outward(&mut surface, &part);

        let mut oriented = skin.triangles.clone();
        for (&t, turned) in kept.iter().zip(&surface.triangles) {
            if !same_way(all[t], *turned) {
                oriented[t].swap(1, 2);
                report.turned_triangles += 1;
            }
        }
        Ok(Self {
            surface,
            skin_triangles,
            stands_for,
            held,
            rims,
            oriented,
            report,
        })
    }

    /// The report with the self-intersections counted.
    pub fn full_report(&self) -> SkinReport {
        let mut report = self.report.clone();
        report.self_intersections = self_intersections(&self.skin());
        report
    }

    /// The surface without the vertices that it does not use, and the vertex that each was.
    pub fn compact(&self) -> (Surface, Vec<u32>) {
        let mut used = vec![false; self.surface.positions.len()];
        (self.surface.triangles.iter().flatten()).for_each(|&v| used[v as usize] = true);
        let old: Vec<u32> = (0..used.len() as u32)
            .filter(|&v| used[v as usize])
            .collect();
        let mut new = vec![0; used.len()];
        (old.iter().enumerate()).for_each(|(n, &v)| new[v as usize] = n as u32);
        let surface = Surface {
            positions: old
                .iter()
                .map(|&v| self.surface.positions[v as usize])
                .collect(),
            triangles: (self.surface.triangles.iter())
                .map(|t| t.map(|v| new[v as usize]))
                .collect(),
        };
        (surface, old)
    }

    /// The fans over hole `h`, looking outward.
    pub fn cap(&self, h: usize) -> Surface {
        let centre = (self.report.vertices + h) as u32;
        let fans = self.surface.triangles[self.skin_triangles..]
            .iter()
            .copied();
        Surface {
            positions: self.surface.positions.clone(),
            triangles: fans.filter(|t| t.contains(&centre)).collect(),
        }
    }

    /// The skin's own vertices and sound triangles.
    pub fn skin(&self) -> Surface {
        Surface {
            positions: self.surface.positions[..self.report.vertices].to_vec(),
            triangles: self.surface.triangles[..self.skin_triangles].to_vec(),
        }
    }
}

/// Whether `b` is a rotation of `a`.
fn same_way(a: [u32; 3], b: [u32; 3]) -> bool {
    (0..3).any(|r| (0..3).all(|i| a[i] == b[(i + r) % 3]))
}

/// Joins vertices of the border that lie in the same place: a seam between parts that follow their bones
/// differently. Each vertex with the one that stands for it.
fn stitch(skin: &Surface, report: &mut SkinReport) -> Vec<u32> {
    let mut border = vec![false; skin.positions.len()];
    for (&(a, b), sides) in &edges(&skin.triangles) {
        if sides.len() == 1 {
            border[a as usize] = true;
            border[b as usize] = true;
        }
    }
    let cell = SEAM * extent(skin);
    let key = |v: usize| {
        (skin.positions[v] / cell)
            .round()
            .to_array()
            .map(|x| x as i64)
    };
    let mut first: HashMap<[i64; 3], u32> = HashMap::new();
    let stands_for: Vec<u32> = (0..border.len())
        .map(|v| match border[v] && cell > 0.0 {
            true => *first.entry(key(v)).or_insert(v as u32),
            false => v as u32,
        })
        .collect();
    report.stitched_vertices = (stands_for.iter().zip(0..))
        .filter(|&(&first, v)| first != v)
        .count();
    stands_for
}

/// Indices of the triangles with three corners, each set of corners once. A needle without area
/// stays, for its neighbours' sake.
fn distinct_triangles(skin: &Surface, stands_for: &[u32], report: &mut SkinReport) -> Vec<usize> {
    let mut seen = HashSet::new();
    let mut used = vec![false; skin.positions.len()];
    let mut kept = Vec::with_capacity(skin.triangles.len());
    for (t, &[a, b, c]) in skin.triangles.iter().enumerate() {
        let [p, q, r] = skin.corners(t);
        let longest = (p - q).length_squared().max((q - r).length_squared());
        let longest = longest.max((r - p).length_squared());
        if skin.area_vector(t).length() <= LEAST_AREA * longest {
            report.degenerate_triangles += 1;
        }
        if a == b || b == c || c == a {
            continue;
        }
        let mut corners = [a, b, c];
        corners.sort_unstable();
        if seen.insert(corners) {
            kept.push(t);
            corners.iter().for_each(|&v| used[v as usize] = true);
        } else {
            report.duplicate_triangles += 1;
        }
    }
    let used = stands_for.iter().filter(|&&v| used[v as usize]).count();
    report.isolated_vertices = stands_for.len() - used;
    kept
}

/// The triangles at each edge (smaller vertex first), each with whether it runs along it.
fn edges(triangles: &[[u32; 3]]) -> BTreeMap<(u32, u32), Vec<(u32, bool)>> {
    let mut edges: BTreeMap<(u32, u32), Vec<(u32, bool)>> = BTreeMap::new();
    for (t, &[a, b, c]) in triangles.iter().enumerate() {
        for (u, v) in [(a, b), (b, c), (c, a)] {
            let sides = edges.entry((u.min(v), u.max(v))).or_default();
            sides.push((t as u32, u < v));
        }
    }
    edges
}

/// Makes neighbours across edges of two triangles look the same way: in each patch of them the
/// smaller part is turned.
fn make_consistent(surface: &mut Surface) {
    let mut neighbours: Vec<Vec<(u32, bool)>> = vec![Vec::new(); surface.triangles.len()];
    for sides in edges(&surface.triangles).values() {
        if let &[(s, along_s), (t, along_t)] = sides.as_slice() {
            neighbours[s as usize].push((t, along_s == along_t));
            neighbours[t as usize].push((s, along_s == along_t));
        }
    }
    let mut turned: Vec<Option<bool>> = vec![None; surface.triangles.len()];
    for first in 0..turned.len() {
        if turned[first].is_some() {
            continue;
        }
        turned[first] = Some(false);
        let mut patch = vec![first];
        let mut next = 0;
        while let Some(&t) = patch.get(next) {
            next += 1;
            for &(s, opposed) in &neighbours[t] {
                if turned[s as usize].is_none() {
                    turned[s as usize] = turned[t].map(|turn| turn != opposed);
                    patch.push(s as usize);
                }
            }
        }
        let minority = patch.iter().filter(|&&t| turned[t] == Some(true)).count();
        let other_way = 2 * minority > patch.len();
        for &t in &patch {
            if (turned[t] == Some(true)) != other_way {
                surface.triangles[t].swap(1, 2);
            }
        }
    }
}

/// Holds the ends of edges that have more than two triangles, or two that still run the same way.
fn mark_non_manifold(surface: &Surface, held: &mut [bool], report: &mut SkinReport) {
    for (&(a, b), sides) in &edges(&surface.triangles) {
        let sound = match sides.as_slice() {
            [_] => true,
            [s, t] => s.1 != t.1,
            _ => false,
        };
        if !sound {
            report.non_manifold_edges += 1;
            held[a as usize] = true;
            held[b as usize] = true;
        }
    }
}

/// The part of each vertex: vertices that triangles join.
fn parts(surface: &Surface, report: &mut SkinReport) -> Vec<u32> {
    let mut sets = DisjointSets::new(surface.positions.len());
    for &[a, b, c] in &surface.triangles {
        sets.union(a, b);
        sets.union(b, c);
    }
    let part: Vec<u32> = (0..surface.positions.len() as u32)
        .map(|v| sets.find(v))
        .collect();
    let named: HashSet<u32> = (surface.triangles.iter())
        .map(|t| part[t[0] as usize])
        .collect();
    report.parts = named.len();
    part
}

/// Adds a fan over every part of the boundary, so that the surface encloses a volume; returns the
/// rims.
fn close_holes(surface: &mut Surface, held: &mut [bool], report: &mut SkinReport) -> Vec<Vec<u32>> {
    // Edges that run one way more often than the other, once for each time.
    let mut open: Vec<(u32, u32)> = Vec::new();
    for (&(a, b), sides) in &edges(&surface.triangles) {
        let along = sides.iter().filter(|s| s.1).count();
        let against = sides.len() - along;
        open.extend(std::iter::repeat_n((a, b), along.saturating_sub(against)));
        open.extend(std::iter::repeat_n((b, a), against.saturating_sub(along)));
    }
    let mut sets = DisjointSets::new(surface.positions.len());
    open.iter().for_each(|&(a, b)| sets.union(a, b));
    let mut loops: BTreeMap<u32, Vec<(u32, u32)>> = BTreeMap::new();
    for &(a, b) in &open {
        loops.entry(sets.find(a)).or_default().push((a, b));
    }
    let place = |surface: &Surface, v: u32| surface.positions[v as usize];
    let mut rims = Vec::new();
    for rim in loops.values() {
        let middle = rim.iter().map(|e| place(surface, e.0)).sum::<DVec3>() / rim.len() as f64;
        let lengths = rim
            .iter()
            .map(|&(a, b)| place(surface, a).distance(place(surface, b)));
        report.holes.push(Hole {
            edges: rim.len(),
            perimeter: lengths.sum(),
            place: middle.to_array(),
        });
        let centre = surface.positions.len() as u32;
        surface.positions.push(middle);
        for &(a, b) in rim {
            surface.triangles.push([b, a, centre]);
            held[a as usize] = true;
            held[b as usize] = true;
        }
        rims.push(rim.iter().map(|e| e.0).collect());
    }
    rims
}

/// Turns every part that encloses a negative volume, unless it lies inside another part: that is a
/// cavity.
fn turn_outward(surface: &mut Surface, part: &[u32]) {
    let mut of_part: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (t, triangle) in surface.triangles.iter().enumerate() {
        // The first corner of a fan is a vertex of the skin.
        of_part
            .entry(part[triangle[0] as usize])
            .or_default()
            .push(t as u32);
    }
    let volume = |surface: &Surface, triangles: &[u32]| -> f64 {
        // From a point of the part, so that far-away parts lose no digits.
        let origin = surface.corners(triangles[0] as usize)[0];
        let spanned = triangles.iter().map(|&t| {
            let [a, b, c] = surface.corners(t as usize).map(|p| p - origin);
            a.dot(b.cross(c)) / 6.0
        });
        spanned.sum()
    };
    let mut order: Vec<(f64, Vec<u32>)> = (of_part.into_values())
        .map(|triangles| (volume(surface, &triangles), triangles))
        .collect();
    // The largest first: it is no cavity.
    order.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    let mut done: Vec<u32> = Vec::new();
    for (volume, triangles) in order {
        let areas = triangles
            .iter()
            .map(|&t| surface.area_vector(t as usize).length());
        if volume < -FLAT * areas.sum::<f64>().powf(1.5) {
            let place = surface.corners(triangles[0] as usize).iter().sum::<DVec3>() / 3.0;
            let around = done.iter().map(|&t| surface.corners(t as usize));
            if winding_number(place, around) < 0.5 {
                (triangles.iter()).for_each(|&t| surface.triangles[t as usize].swap(1, 2));
            }
        }
        done.extend(triangles);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample::{Finger, Limb};

    fn finger() -> Surface {
        Finger::default().body().unwrap().skin
    }

    #[test]
    fn fans_close_the_cut_ends() {
        let skin = Limb::S.body().unwrap().skin;
        assert!(!skin.is_closed());
        let sound = SoundSkin::new(&skin).unwrap();
        assert!(sound.surface.is_closed());
        assert_eq!(sound.report.holes.len(), 2);
        assert_eq!(sound.surface.positions.len(), skin.positions.len() + 2);
        let rims = sound.held.iter().filter(|held| **held).count();
        assert_eq!(rims, sound.rims.iter().map(Vec::len).sum::<usize>());
        for (h, hole) in sound.report.holes.iter().enumerate() {
            assert_eq!(sound.cap(h).triangles.len(), hole.edges);
        }
        let again = SoundSkin::new(&sound.surface).unwrap();
        assert_eq!(again.surface, sound.surface);
        assert_eq!(again.report.turned_triangles, 0);
    }

    #[test]
    fn what_looks_inward_is_turned_but_cavities_stay() {
        let skin = finger();
        let mut other = skin.clone();
        other.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        let sound = SoundSkin::new(&other).unwrap();
        assert!(sound.surface.volume() > 0.0 && sound.surface.is_closed());
        assert_eq!(sound.report.turned_triangles, skin.triangles.len());
        assert_eq!(sound.oriented, sound.surface.triangles);
        // A few only.
        let mut mixed = skin.clone();
        for t in [3, 57, 200, 201] {
            mixed.triangles[t].swap(1, 2);
        }
        let sound = SoundSkin::new(&mixed).unwrap();
        assert_eq!(sound.report.turned_triangles, 4);
        assert!(sound.surface.is_closed() && sound.report.holes.is_empty());
        // A small copy inside, looking inward: a cavity.
        let middle = DVec3::new(0.03, 0.0, 0.0);
        let small = |p: &DVec3| middle + 0.3 * (*p - middle);
        let shift = skin.positions.len() as u32;
        let mut hollow = skin.clone();
        hollow.positions.extend(skin.positions.iter().map(small));
        let inner = skin.triangles.iter().map(|t| t.map(|v| v + shift));
        hollow.triangles.extend(inner.map(|[a, b, c]| [a, c, b]));
        let sound = SoundSkin::new(&hollow).unwrap();
        assert_eq!((sound.report.parts, sound.report.turned_triangles), (2, 0));
        // Outside the other one it is a body that looks the wrong way.
        for p in &mut hollow.positions[skin.positions.len()..] {
            p.y += 1.0;
        }
        let sound = SoundSkin::new(&hollow).unwrap();
        assert_eq!(sound.report.turned_triangles, skin.triangles.len());
    }

    #[test]
    fn faults_are_counted() {
        let mut skin = finger();
        let sound = SoundSkin::new(&skin).unwrap();
        assert_eq!(
            sound.full_report(),
            SkinReport {
                vertices: skin.positions.len(),
                triangles: skin.triangles.len(),
                parts: 1,
                ..SkinReport::default()
            }
        );
        let [a, b, c] = skin.triangles[100];
        skin.triangles.extend([[b, c, a], [a, a, b]]);
        skin.positions.push(DVec3::ONE);
        // A fin on an edge.
        let tip = skin.positions.len() as u32;
        skin.positions.push(skin.positions[a as usize] + DVec3::Y);
        skin.triangles.push([b, a, tip]);
        let report = SoundSkin::new(&skin).unwrap().full_report();
        assert_eq!(report.duplicate_triangles, 1);
        assert_eq!(report.degenerate_triangles, 1);
        assert_eq!(report.isolated_vertices, 1);
        assert_eq!(report.non_manifold_edges, 1);
        skin.positions[0].x = f64::NAN;
        assert!(SoundSkin::new(&skin).is_err());
        assert!(SoundSkin::new(&Surface::default()).is_err());
    }

    #[test]
    fn two_fingers_that_cross_cut_each_other() {
        let skin = finger();
        let mut crossed = skin.clone();
        let shift = skin.positions.len() as u32;
        let place = |p: &DVec3| DVec3::new(0.04 + p.y, p.x - 0.04, p.z);
        crossed.positions.extend(skin.positions.iter().map(place));
        let other = skin.triangles.iter().map(|t| t.map(|v| v + shift));
        crossed.triangles.extend(other.map(|[a, b, c]| [a, c, b]));
        let report = SoundSkin::new(&crossed).unwrap().full_report();
        assert!(report.self_intersections > 50, "{report}");
        assert_eq!(report.parts, 2);
    }
}
