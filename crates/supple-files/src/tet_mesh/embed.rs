//! Points of a skin in a tet mesh: barycentric coordinates of the tet around each, or of the closest place
//! of the mesh's surface where there is none.

use glam::DVec3;
use supple::internal::math::{Rows, par_map};
use supple::model::TetMesh;
use supple::{Error, Result};
use supple_bake::math::NearestPoint;

/// A point this near to a node, relative to the mesh's extent, is the node.
const SAME: f64 = 1e-7;

/// The farthest that a point may lie outside the mesh, relative to its extent.
const FARTHEST: f64 = 0.05;

/// Nodes and shares of each point; the shares are not negative and sum to 1.
///
/// # Errors
/// [`Error::Invalid`] where a point lies farther from the mesh than a twentieth of its extent.
pub(super) fn embed(mesh: &TetMesh, points: &[DVec3]) -> Result<Rows<(u32, f64)>> {
    let low = mesh.nodes.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = mesh
        .nodes
        .iter()
        .copied()
        .fold(DVec3::NEG_INFINITY, DVec3::max);
    let extent = (high - low).length();
    let search = Search::new(mesh);
    let found = par_map(points.len(), |v| {
        let p = points[v];
        match search.nodes.nearest(p) {
            Some((node, distance)) if distance <= SAME * extent => (vec![(node, 1.0)], 0.0),
            _ => search
                .inside(p)
                .map_or_else(|| search.closest(p), |shares| (shares, 0.0)),
        }
    });
    let distances = found.iter().enumerate().map(|(v, f)| (f.1, v));
    let worst = distances.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
    if let Some((distance, v)) = worst.filter(|w| w.0 > FARTHEST * extent) {
        let problem = format!(
            "skin vertex {v} lies {distance:.3} m outside the tets, which are {extent:.3} m across: mesh this very \
             skin, in metres"
        );
        return Err(Error::invalid("layer.skin_embedding", problem));
    }
    Ok(found.into_iter().map(|f| f.0).collect())
}

struct Search<'a> {
    mesh: &'a TetMesh,
    nodes: NearestPoint<'a>,
    /// Tets by their lowest x, with it and the highest.
    spans: Vec<(f64, f64, u32)>,
    /// The widest span.
    widest: f64,
    /// The mesh's surface, each triangle with a ball around it.
    surface: Vec<([u32; 3], DVec3, f64)>,
}

impl<'a> Search<'a> {
    fn new(mesh: &'a TetMesh) -> Self {
        let span = |t: usize| {
            let x = mesh.corners(t).map(|c| c.x);
            let low = x.into_iter().fold(f64::INFINITY, f64::min);
            let high = x.into_iter().fold(f64::NEG_INFINITY, f64::max);
            (low, high, t as u32)
        };
        let mut spans: Vec<_> = (0..mesh.tets.len()).map(span).collect();
        spans.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
        let ball = |face: [u32; 3]| {
            let corners = face.map(|n| mesh.nodes[n as usize]);
            let centre = corners.iter().sum::<DVec3>() / 3.0;
            let radius = corners
                .map(|c| c.distance(centre))
                .into_iter()
                .fold(0.0, f64::max);
            (face, centre, radius)
        };
        Self {
            mesh,
            nodes: NearestPoint::new(&mesh.nodes),
            widest: spans.iter().map(|s| s.1 - s.0).fold(0.0, f64::max),
            spans,
            surface: mesh.boundary_triangles().into_iter().map(ball).collect(),
        }
    }

    /// Coordinates in the tet that holds `p`, the first of several.
    fn inside(&self, p: DVec3) -> Option<Vec<(u32, f64)>> {
        const ROUNDING: f64 = 1e-12;
        let first = self.spans.partition_point(|s| s.0 < p.x - self.widest);
        let spans = self.spans[first..].iter().take_while(|s| s.0 <= p.x);
        let holders = spans.filter(|s| s.1 >= p.x).filter_map(|s| {
            let t = s.2 as usize;
            let shares = self.mesh.barycentric(t, p);
            shares
                .iter()
                .all(|s| *s >= -ROUNDING)
                .then_some((t, shares))
        });
        let (t, shares) = holders.min_by_key(|h| h.0)?;
        Some(shared(self.mesh.tets[t], shares))
    }

    /// Coordinates of the surface's closest place to `p`, and its distance.
    fn closest(&self, p: DVec3) -> (Vec<(u32, f64)>, f64) {
        let mut best = (Vec::new(), f64::INFINITY);
        for (face, centre, radius) in &self.surface {
            if p.distance(*centre) - radius >= best.1 {
                continue;
            }
            let corners = face.map(|n| self.mesh.nodes[n as usize]);
            let shares = closest_shares(p, &corners);
            let place: DVec3 = shares.iter().zip(corners).map(|(s, c)| *s * c).sum();
            if p.distance(place) < best.1 {
                best = (shared(*face, shares), p.distance(place));
            }
        }
        best
    }
}

/// Nodes with shares above 0, which are made to sum to 1.
fn shared<const N: usize>(nodes: [u32; N], shares: [f64; N]) -> Vec<(u32, f64)> {
    let sum: f64 = shares.iter().map(|s| s.max(0.0)).sum();
    let pairs = nodes.into_iter().zip(shares);
    pairs
        .filter(|p| p.1 > 0.0)
        .map(|(n, s)| (n, s / sum))
        .collect()
}

/// Barycentric coordinates of the place of a triangle that is closest to `p`: its projection if that lies
/// inside, else the closest of the edges' places.
fn closest_shares(p: DVec3, &[a, b, c]: &[DVec3; 3]) -> [f64; 3] {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let normal = ab.cross(ac);
    let area = normal.length_squared();
    let v = normal.dot(ap.cross(ac)) / area;
    let w = normal.dot(ab.cross(ap)) / area;
    if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
        return [1.0 - v - w, v, w];
    }
    let corners = [a, b, c];
    let on_edge = |i: usize| {
        let j = (i + 1) % 3;
        let edge = corners[j] - corners[i];
        let u = (p - corners[i]).dot(edge) / edge.length_squared().max(f64::MIN_POSITIVE);
        let u = u.clamp(0.0, 1.0);
        let mut shares = [0.0; 3];
        shares[i] = 1.0 - u;
        shares[j] = u;
        (shares, (corners[i] + u * edge).distance_squared(p))
    };
    let edges = [on_edge(0), on_edge(1), on_edge(2)];
    let nearest = edges.into_iter().min_by(|x, y| x.1.total_cmp(&y.1));
    nearest.map_or([1.0, 0.0, 0.0], |e| e.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use supple::internal::math::Random;

    /// A cube of five tets.
    fn cube() -> TetMesh {
        let corner = |i: u32| DVec3::from_array([0, 1, 2].map(|axis| f64::from(i >> axis & 1)));
        TetMesh {
            nodes: (0..8).map(corner).collect(),
            tets: vec![
                [0, 1, 2, 4],
                [3, 2, 1, 7],
                [5, 4, 7, 1],
                [6, 7, 4, 2],
                [1, 2, 4, 7],
            ],
        }
    }

    fn place(mesh: &TetMesh, row: &[(u32, f64)]) -> DVec3 {
        row.iter()
            .map(|(n, share)| *share * mesh.nodes[*n as usize])
            .sum()
    }

    #[test]
    fn points_inside_are_where_they_are_and_others_at_the_closest_place() {
        let mesh = cube();
        assert!((0..5).all(|t| mesh.volume(t) > 0.0));
        let mut random = Random::new(4);
        let centre = DVec3::splat(0.5);
        let points: Vec<DVec3> = (0..500).map(|_| centre + random.vector(0.55)).collect();
        let rows = embed(&mesh, &points).unwrap();
        let mut outside = 0;
        for (p, row) in points.iter().zip(rows.iter()) {
            let expected = p.clamp(DVec3::ZERO, DVec3::ONE);
            outside += usize::from(expected != *p);
            assert!(place(&mesh, row).distance(expected) < 1e-12, "{p}: {row:?}");
            let sum: f64 = row.iter().map(|e| e.1).sum();
            assert!((sum - 1.0).abs() < 1e-12 && row.iter().all(|e| e.1 > 0.0));
        }
        assert!((20..480).contains(&outside));
    }

    #[test]
    fn nodes_are_themselves_and_what_is_far_away_is_refused() {
        let mesh = cube();
        let rows = embed(&mesh, &mesh.nodes).unwrap();
        assert!(
            rows.iter()
                .enumerate()
                .all(|(n, row)| *row == [(n as u32, 1.0)])
        );
        let far = embed(&mesh, &[DVec3::ZERO, DVec3::splat(1000.0)]).unwrap_err();
        assert!(far.to_string().contains("skin vertex 1"), "{far}");
    }
}
