//! Distances to a surface and insides of it, through a tree of boxes (an R*-tree).

use glam::DVec3;
use rstar::{AABB, PointDistance, RTree, RTreeObject};
use supple::model::Surface;

/// The triangles of a surface, sorted for searches.
pub(crate) struct TriangleTree {
    tree: RTree<Triangle>,
}

struct Triangle([DVec3; 3]);

impl RTreeObject for Triangle {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> AABB<[f64; 3]> {
        let [a, b, c] = self.0;
        AABB::from_corners(a.min(b).min(c).to_array(), a.max(b).max(c).to_array())
    }
}

impl PointDistance for Triangle {
    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        let p = DVec3::from_array(*point);
        closest_point(p, &self.0).distance_squared(p)
    }
}

impl TriangleTree {
    /// Of finite triangles.
    pub fn new(triangles: impl Iterator<Item = [DVec3; 3]>) -> Self {
        Self {
            tree: RTree::bulk_load(triangles.map(Triangle).collect()),
        }
    }

    /// Of all triangles of `surface`.
    pub fn of(surface: &Surface) -> Self {
        Self::new((0..surface.triangles.len()).map(|t| surface.corners(t)))
    }

    /// Distance from `p` to the nearest triangle, m; ∞ where there is none.
    pub fn distance(&self, p: DVec3) -> f64 {
        let nearest = self.tree.nearest_neighbor(p.to_array());
        nearest.map_or(f64::INFINITY, |t| t.distance_2(&p.to_array()).sqrt())
    }

    /// How often triangles that are closed wind around `p`: the signed count of those that a ray along x meets.
    pub fn winding_number(&self, p: DVec3) -> i32 {
        let end = [f64::INFINITY, p.y, p.z];
        let met = self
            .tree
            .locate_in_envelope_intersecting(AABB::from_corners(p.to_array(), end));
        met.map(|t| t.crossing(p)).sum()
    }
}

impl Triangle {
    /// 1 where a ray from `p` along x leaves through the triangle, −1 where it enters, else 0. Two triangles of one
    /// edge see the ray on opposite sides of it, so that none slips between them or meets both.
    fn crossing(&self, p: DVec3) -> i32 {
        let [a, b, c] = self.0;
        let left = |from: DVec3, to: DVec3| {
            let flip = (from.y, from.z, from.x) > (to.y, to.z, to.x);
            let (from, to) = if flip { (to, from) } else { (from, to) };
            let side = (to.y - from.y) * (p.z - from.z) - (to.z - from.z) * (p.y - from.y);
            (side >= 0.0) != flip
        };
        let sign = match [left(a, b), left(b, c), left(c, a)] {
            [true, true, true] => 1,
            [false, false, false] => -1,
            _ => return 0,
        };
        let normal = (b - a).cross(c - a);
        let rise = normal.y * (p.y - a.y) + normal.z * (p.z - a.z);
        // The projection has area, so that the normal's x is not 0.
        if a.x - rise / normal.x > p.x { sign } else { 0 }
    }
}

/// The place of a triangle that is closest to `p` (Ericson, Real-Time Collision Detection, §5.1.5).
pub(crate) fn closest_point(p: DVec3, &[a, b, c]: &[DVec3; 3]) -> DVec3 {
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    let on_segment = |from: DVec3, to: DVec3| {
        let edge = to - from;
        let u = (p - from).dot(edge) / edge.length_squared().max(f64::MIN_POSITIVE);
        from + u.clamp(0.0, 1.0) * edge
    };
    let area = normal.length_squared();
    // Barycentric coordinates of the projection.
    let v = normal.dot((p - a).cross(ac)) / area;
    let w = normal.dot(ab.cross(p - a)) / area;
    if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
        return a + v * ab + w * ac;
    }
    let candidates = [on_segment(a, b), on_segment(b, c), on_segment(c, a)];
    let distance = |q: &DVec3| (*q - p).length_squared();
    (candidates.into_iter())
        .min_by(|x, y| distance(x).total_cmp(&distance(y)))
        .unwrap_or(a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::winding_number;
    use supple::internal::math::Random;

    /// A closed surface that crosses itself: two tetrahedra, one in the other's way, one of them twice.
    fn surface() -> Vec<[DVec3; 3]> {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
        let solid = |shift: DVec3| faces.map(|f| f.map(|c| corners[c] + shift));
        let shifted = solid(DVec3::splat(0.1));
        [solid(DVec3::ZERO), shifted, shifted].concat()
    }

    #[test]
    fn distances_are_those_of_a_full_search() {
        let triangles = surface();
        let tree = TriangleTree::new(triangles.iter().copied());
        let mut random = Random::new(3);
        for _ in 0..500 {
            let p = random.vector(2.0);
            let distances = triangles.iter().map(|t| closest_point(p, t).distance(p));
            let expected = distances.fold(f64::INFINITY, f64::min);
            assert!((tree.distance(p) - expected).abs() < 1e-15);
        }
        assert_eq!(
            TriangleTree::new([].into_iter()).distance(DVec3::X),
            f64::INFINITY
        );
    }

    #[test]
    fn the_winding_number_is_that_of_solid_angles() {
        let triangles = surface();
        let tree = TriangleTree::new(triangles.iter().copied());
        let mut random = Random::new(4);
        let mut seen = [0; 4];
        for _ in 0..4000 {
            let p = random.vector(0.7);
            let expected = winding_number(p, triangles.iter().copied());
            assert!(
                (f64::from(tree.winding_number(p)) - expected).abs() < 1e-6,
                "{p}"
            );
            seen[expected.round() as usize] += 1;
        }
        assert!(seen.iter().all(|n| *n > 20), "{seen:?}");
        // Rays through corners and along edges of the lower tetrahedron.
        for (p, expected) in [
            (DVec3::new(-1.0, 0.0, 0.0), 0),
            (DVec3::new(-1.0, 0.5, 0.0), 0),
            (DVec3::new(-1.0, 0.0, 1.0), 0),
            (DVec3::new(0.05, 0.05, 0.05), 1),
        ] {
            assert_eq!(tree.winding_number(p), expected, "{p}");
        }
    }
}
