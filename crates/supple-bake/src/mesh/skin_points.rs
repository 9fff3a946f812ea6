//! Points on the skin's wireframe, so that the lattice follows the skin's own connections: a tet that
//! holds a piece of skin is kept however little of it is tissue, and two pieces are one only where
//! the skin or the solid joins them.

use super::bcc::{BccLattice, share_face};
use super::disjoint_sets::DisjointSets;
use super::samples::Samples;
use glam::DVec3;
use std::collections::HashMap;
use supple::internal::math::par_map;
use supple::model::Surface;

/// Halvings of an edge until two points lie in tets that share a face.
const HALVINGS: usize = 24;

/// A point of the skin in its tet.
struct SkinPoint {
    place: DVec3,
    tet: u32,
    /// The triangles that hold it.
    triangles: Vec<u32>,
}

/// The skin's points, joined with each other and with the samples.
pub(super) struct SkinPoints {
    /// The tet of each point; point `i` is element `samples + i` of the sets. The skin's vertices
    /// come first, in their order.
    pub tets: Vec<u32>,
    /// Elements in tets that share a face, joined across it.
    pub across_faces: Vec<(u32, u32)>,
}

impl SkinPoints {
    /// Spreads points over the wireframe of `skin`, adds them to `sets` after the samples, and joins
    /// those of one tet that a triangle, an edge or a straight way through the solid connects.
    pub fn new(
        lattice: &BccLattice,
        samples: &Samples,
        skin: &Surface,
        sets: &mut DisjointSets,
    ) -> Self {
        let mut walk = Walk {
            lattice,
            sets,
            first: samples.len(),
            points: Vec::new(),
            pieces: HashMap::new(),
            across_faces: Vec::new(),
        };
        for (&place, triangles) in skin.positions.iter().zip(skin.triangles_around().iter()) {
            walk.add(place, triangles.to_vec());
        }
        for (a, b, triangles) in edges(skin) {
            let (from, to) = (skin.positions[a as usize], skin.positions[b as usize]);
            let steps = ((to - from).length() / (0.25 * lattice.cell))
                .ceil()
                .max(1.0) as usize;
            let mut last = a as usize;
            for step in 1..=steps {
                let next = if step == steps {
                    b as usize
                } else {
                    walk.add(from.lerp(to, step as f64 / steps as f64), triangles.clone())
                };
                walk.connect(last, next, HALVINGS);
                last = next;
            }
        }
        walk.join_with_samples(samples, skin);
        Self {
            tets: walk.points.iter().map(|p| p.tet).collect(),
            across_faces: walk.across_faces,
        }
    }
}

struct Walk<'a> {
    lattice: &'a BccLattice,
    sets: &'a mut DisjointSets,
    first: usize,
    points: Vec<SkinPoint>,
    /// A point of each (triangle, tet): what they share is convex, so all points of it are joined.
    pieces: HashMap<(u32, u32), usize>,
    across_faces: Vec<(u32, u32)>,
}

impl Walk<'_> {
    fn element(&self, point: usize) -> u32 {
        (self.first + point) as u32
    }

    fn add(&mut self, place: DVec3, triangles: Vec<u32>) -> usize {
        let (point, tet) = (self.points.len(), self.lattice.locate(place));
        let element = self.sets.push();
        debug_assert_eq!(element, self.element(point));
        for &triangle in &triangles {
            let twin = *self.pieces.entry((triangle, tet)).or_insert(point);
            self.sets.union(element, self.element(twin));
        }
        self.points.push(SkinPoint {
            place,
            tet,
            triangles,
        });
        point
    }

    /// Connects two points of an edge through the tets between them.
    fn connect(&mut self, a: usize, b: usize, halvings: usize) {
        let [p, q] = [a, b].map(|i| self.points[i].tet);
        if p == q {
            self.sets.union(self.element(a), self.element(b));
        } else if share_face(&self.lattice.tet_nodes(p), &self.lattice.tet_nodes(q)) {
            self.across_faces.push((self.element(a), self.element(b)));
        } else if halvings > 0 {
            let middle = 0.5 * (self.points[a].place + self.points[b].place);
            // The triangles of the edge: those that both ends lie on.
            let (ours, theirs) = (&self.points[a].triangles, &self.points[b].triangles);
            let both = ours
                .iter()
                .filter(|t| theirs.contains(t))
                .copied()
                .collect();
            let middle = self.add(middle, both);
            self.connect(a, middle, halvings - 1);
            self.connect(middle, b, halvings - 1);
        }
    }

    /// Joins every point with the nearest sample it sees: within its tet if there is one, else across
    /// a face.
    fn join_with_samples(&mut self, samples: &Samples, skin: &Surface) {
        let near = TrianglesByCell::new(self.lattice, skin);
        let seen = par_map(self.points.len(), |i| {
            nearest_seen(self.lattice, samples, skin, &near, &self.points[i])
        });
        for (point, seen) in seen.into_iter().enumerate() {
            let element = self.element(point);
            match seen {
                Some((sample, true)) => self.sets.union(element, sample as u32),
                Some((sample, false)) => self.across_faces.push((element, sample as u32)),
                None => {}
            }
        }
    }
}

/// The nearest solid sample that `point` sees, and whether it lies in the same tet.
fn nearest_seen(
    lattice: &BccLattice,
    samples: &Samples,
    skin: &Surface,
    near: &TrianglesByCell,
    point: &SkinPoint,
) -> Option<(usize, bool)> {
    let nodes = lattice.tet_nodes(point.tet);
    let sees = |s: &usize| !near.blocks(lattice, skin, point, samples.position(*s));
    let around = samples.around(point.place);
    let beside = |s: &usize| share_face(&nodes, &lattice.tet_nodes(samples.tet(*s)));
    let nearby = |s: &usize| samples.tet(*s) == point.tet;
    let here = (around.iter().copied().filter(nearby).find(sees))
        // A tet that the skin cuts in two places may have its samples at the other.
        .or_else(|| {
            samples
                .in_tet(point.tet, point.place)
                .into_iter()
                .find(sees)
        });
    here.map(|s| (s, true)).or_else(|| {
        around
            .into_iter()
            .filter(beside)
            .find(sees)
            .map(|s| (s, false))
    })
}

/// The triangles whose box meets each lattice cell.
struct TrianglesByCell {
    of_cell: HashMap<[i32; 3], Vec<u32>>,
}

impl TrianglesByCell {
    fn new(lattice: &BccLattice, skin: &Surface) -> Self {
        let mut of_cell: HashMap<[i32; 3], Vec<u32>> = HashMap::new();
        for t in 0..skin.triangles.len() {
            for cell in cells_between(lattice, &skin.corners(t)) {
                of_cell.entry(cell).or_default().push(t as u32);
            }
        }
        Self { of_cell }
    }

    /// Whether a triangle stands between `point` and `place`, those that hold the point aside.
    fn blocks(
        &self,
        lattice: &BccLattice,
        skin: &Surface,
        point: &SkinPoint,
        place: DVec3,
    ) -> bool {
        cells_between(lattice, &[point.place, place])
            .filter_map(|cell| self.of_cell.get(&cell))
            .flatten()
            .filter(|t| !point.triangles.contains(t))
            .any(|&t| segment_meets(point.place, place, &skin.corners(t as usize)))
    }
}

/// The lattice cells that the box around `points` meets.
fn cells_between(lattice: &BccLattice, points: &[DVec3]) -> impl Iterator<Item = [i32; 3]> + use<> {
    let cell = |p: DVec3| {
        ((p - lattice.origin) / lattice.cell)
            .floor()
            .as_ivec3()
            .to_array()
    };
    let low = cell(points.iter().copied().fold(DVec3::INFINITY, DVec3::min));
    let high = cell(points.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max));
    (low[2]..=high[2]).flat_map(move |k| {
        (low[1]..=high[1]).flat_map(move |j| (low[0]..=high[0]).map(move |i| [i, j, k]))
    })
}

/// Whether the segment `p`–`q` meets a triangle (Möller and Trumbore 1997), its border included.
pub(super) fn segment_meets(p: DVec3, q: DVec3, &[a, b, c]: &[DVec3; 3]) -> bool {
    let (way, ab, ac) = (q - p, b - a, c - a);
    let h = way.cross(ac);
    let scale = ab.dot(h);
    if scale == 0.0 {
        return false;
    }
    let from = (p - a) / scale;
    let u = from.dot(h);
    let g = from.cross(ab);
    let (v, t) = (way.dot(g), ac.dot(g));
    let slack = 1e-9;
    u >= -slack && v >= -slack && u + v <= 1.0 + slack && (0.0..=1.0).contains(&t)
}

/// Every edge once, with its triangles.
fn edges(skin: &Surface) -> Vec<(u32, u32, Vec<u32>)> {
    let mut sides: Vec<(u32, u32, u32)> = (skin.triangles.iter().zip(0..))
        .flat_map(|(&[a, b, c], t)| [(a, b), (b, c), (c, a)].map(|(u, v)| (u.min(v), u.max(v), t)))
        .collect();
    sides.sort_unstable();
    sides
        .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
        .map(|sides| (sides[0].0, sides[0].1, sides.iter().map(|s| s.2).collect()))
        .collect()
}
