//! The solid inside a closed triangle mesh: d interpolated between samples of its signed distance.
//!
//! At the nodes of a grid around the mesh d is exact; between them it is trilinear, which misses a smooth
//! d by at most ⅛ Σ s_k² |∂²d/∂x_k²| with spacings s (a ball of radius r: s²/(4 r)), and rounds edges and
//! corners off within a cell. Beyond the grid d grows with the distance from it.
//!
//! n is the exact gradient of that interpolant and no unit vector: its length is 1 up to the same error. Contact
//! needs the gradient, since E = ½ k a (d̂ − d)₊² pushes with −∂E/∂x = k a (d̂ − d)₊ ∇d, whatever ∇d's length; made a
//! unit vector it would be the gradient of no energy. Only friction needs a plane: it takes ∇d/|∇d|, and λ is
//! the length of the push ([`crate::potential::cpu::compact::lag`]). Both twins do the same.

use super::{Shape, SignedDistance};
use crate::math::par_map;
use crate::model::Surface;
use crate::{Error, Result};
use glam::{DMat3, DVec3, IVec3};
#[cfg(feature = "mesh-colliders")]
use parry3d_f64::{
    math::Vector,
    query::PointQuery,
    shape::{TriMesh, TriMeshFlags},
};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::{Arc, LazyLock};

/// Nodes of a grid along each axis: 432 KiB a mesh.
pub const MESH_NODES: usize = 48;

/// Cells between the mesh and the grid's border.
const BORDER: f64 = 4.0;

/// A closed triangle mesh as a collider's shape.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "DistanceGrid", into = "DistanceGrid")]
pub struct MeshShape(Arc<DistanceGrid>);

/// A closed surface and its signed distance at the nodes of a grid.
#[derive(Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "StoredGrid")]
pub struct DistanceGrid {
    surface: Surface,
    /// The node of least coordinates, m.
    low: DVec3,
    /// From a node to the next, m.
    spacing: DVec3,
    /// d, m, as both evaluations have it; x runs fastest.
    values: Vec<f32>,
}

/// A [`DistanceGrid`] as it is read, before its lengths are known to be right.
#[derive(Deserialize)]
struct StoredGrid {
    surface: Surface,
    low: DVec3,
    spacing: DVec3,
    values: Vec<f32>,
}

impl TryFrom<StoredGrid> for DistanceGrid {
    type Error = Error;

    fn try_from(stored: StoredGrid) -> Result<Self> {
        let count = stored.surface.positions.len() as u32;
        let sound = stored.values.len() == MESH_NODES.pow(3)
            && stored.values.iter().all(|d| d.is_finite())
            && stored.low.is_finite()
            && stored.spacing.is_finite()
            && stored.spacing.min_element() > 0.0
            && stored.surface.positions.iter().all(|p| p.is_finite())
            && stored
                .surface
                .triangles
                .iter()
                .flatten()
                .all(|&v| v < count);
        if !sound {
            return Err(Error::invalid("mesh", "is not a grid of distances"));
        }
        Ok(Self {
            surface: stored.surface,
            low: stored.low,
            spacing: stored.spacing,
            values: stored.values,
        })
    }
}

impl From<DistanceGrid> for MeshShape {
    fn from(grid: DistanceGrid) -> Self {
        Self(Arc::new(grid))
    }
}

impl From<MeshShape> for DistanceGrid {
    fn from(shape: MeshShape) -> Self {
        Arc::unwrap_or_clone(shape.0)
    }
}

impl fmt::Debug for DistanceGrid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let triangles = self.surface.triangles.len();
        write!(f, "DistanceGrid of {triangles} triangles")
    }
}

impl MeshShape {
    /// The solid inside a closed `surface`, triangles counter-clockwise from outside.
    ///
    /// # Errors
    /// [`Error::Invalid`] of a surface that is empty, open, inside out or not finite.
    #[cfg(feature = "mesh-colliders")]
    pub fn new(surface: &Surface) -> Result<Self> {
        Ok(Self(Arc::new(DistanceGrid::new(surface)?)))
    }

    /// A wedge: flat sides, sharp and blunt edges, no symmetry.
    pub(super) fn example() -> Self {
        static WEDGE: LazyLock<MeshShape> = LazyLock::new(|| {
            let block = Shape::Box {
                half_extents: [0.03, 0.02, 0.015],
            };
            let mut surface = block.sampled(150).unwrap_or_default();
            (surface.positions.iter_mut()).for_each(|p| p.z *= 1.0 - 15.0 * p.x);
            MeshShape(Arc::new(DistanceGrid::of_wedge(surface)))
        });
        WEDGE.clone()
    }

    /// Radius of a ball about the shape's origin that holds it, m.
    pub(crate) fn bounding_radius(&self) -> f64 {
        let (low, extent) = (self.0.low, self.0.spacing * (MESH_NODES - 1) as f64);
        low.abs().max((low + extent).abs()).length()
    }

    /// Its distances.
    pub fn grid(&self) -> &Arc<DistanceGrid> {
        &self.0
    }
}

/// A cell, and where a point is in it.
struct Cell {
    /// d at its corners: bit k of the index is the side along axis k.
    corners: [f64; 8],
    /// 0 to 1 along each axis.
    place: DVec3,
    /// From the grid's nearest point to the point; 0 within the grid.
    beyond: DVec3,
}

impl DistanceGrid {
    #[cfg(feature = "mesh-colliders")]
    fn new(surface: &Surface) -> Result<Self> {
        let refuse = |problem: &str| Err(Error::invalid("mesh", problem));
        let count = surface.positions.len() as u32;
        if surface.triangles.is_empty() {
            return refuse("holds no triangle");
        }
        if !(surface.positions.iter().all(|p| p.is_finite())
            && surface.triangles.iter().flatten().all(|&v| v < count))
        {
            return refuse("holds a place that is not finite, or names a vertex that is not there");
        }
        if !surface.is_closed() {
            return refuse("is not closed: every edge must join two triangles; weld and fill it");
        }
        if surface.volume() <= 0.0 {
            return refuse("is inside out, or flat: flip its triangles");
        }
        let vector = |p: &DVec3| Vector::new(p.x, p.y, p.z);
        let places = surface.positions.iter().map(vector).collect();
        let triangles = surface.triangles.clone();
        // Without orientation nothing would be inside.
        let mesh = TriMesh::with_flags(places, triangles, TriMeshFlags::ORIENTED)
            .map_err(|e| Error::invalid("mesh", e.to_string()))?;
        let distance = |place: DVec3| {
            let p = vector(&place);
            let nearest = mesh.project_local_point(p, false);
            let length = (nearest.point - p).length();
            if nearest.is_inside { -length } else { length }
        };
        Ok(Self::sampled(surface.clone(), distance))
    }

    /// [`MeshShape::example`]'s: with parry where it is there, and without it the largest of the planes' distances,
    /// which is the same but outside of edges and corners.
    fn of_wedge(surface: Surface) -> Self {
        #[cfg(feature = "mesh-colliders")]
        if let Ok(grid) = Self::new(&surface) {
            return grid;
        }
        let planes: Vec<_> = (surface.triangles.iter())
            .map(|t| {
                let [a, b, c] = t.map(|v| surface.positions[v as usize]);
                (a, (b - a).cross(c - a).normalize())
            })
            .collect();
        let beyond = |p: DVec3| planes.iter().map(move |(a, n)| n.dot(p - *a));
        Self::sampled(surface, |p| beyond(p).fold(f64::NEG_INFINITY, f64::max))
    }

    /// `distance` at the nodes of a grid around `surface`.
    fn sampled(surface: Surface, distance: impl Fn(DVec3) -> f64 + Sync) -> Self {
        let (least, most) = surface.bounds();
        let cells = MESH_NODES as f64 - 1.0;
        // A flat side still gets cells of a tenth of the longest one's.
        let extent = (most - least).max(DVec3::splat(0.1 * (most - least).max_element()));
        // As both evaluations have it.
        let spacing = (extent / (cells - 2.0 * BORDER)).as_vec3().as_dvec3();
        let low = 0.5 * (least + most) - 0.5 * cells * spacing;
        let n = MESH_NODES;
        let slice = |z: usize| -> Vec<f32> {
            let node =
                |i: usize| low + spacing * DVec3::new((i % n) as f64, (i / n) as f64, z as f64);
            (0..n * n).map(|i| distance(node(i)) as f32).collect()
        };
        Self {
            surface,
            low,
            spacing,
            values: par_map(n, slice).concat(),
        }
    }

    /// The mesh.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// The node of least coordinates, m.
    pub fn low(&self) -> DVec3 {
        self.low
    }

    /// From a node to the next along each axis, m.
    pub fn spacing(&self) -> DVec3 {
        self.spacing
    }

    /// d at the nodes, m; x runs fastest.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    fn cell(&self, point: DVec3) -> Cell {
        let n = MESH_NODES as i32;
        let at = (point - self.low) / self.spacing;
        let within = at.clamp(DVec3::ZERO, DVec3::splat(f64::from(n - 1)));
        let first = within.floor().as_ivec3().min(IVec3::splat(n - 2));
        let corner = |k: i32| {
            let node = first + IVec3::new(k & 1, k >> 1 & 1, k >> 2);
            f64::from(self.values[(node.x + n * (node.y + n * node.z)) as usize])
        };
        Cell {
            corners: [0, 1, 2, 3, 4, 5, 6, 7].map(corner),
            place: within - first.as_dvec3(),
            beyond: (at - within) * self.spacing,
        }
    }

    /// d = Σ over corners of d_c Π_k (t_k or 1 − t_k), and its gradient.
    pub(super) fn signed_distance(&self, point: DVec3) -> SignedDistance {
        let cell = self.cell(point);
        let slope = DVec3::from_array([0, 1, 2].map(|k| cell.sum(&[k]))) / self.spacing;
        let beyond = cell.beyond.length();
        if beyond == 0.0 {
            return SignedDistance {
                distance: cell.sum(&[]),
                normal: slope,
            };
        }
        // The nearest point of the border moves only along axes in which the point is within the grid.
        let moves = DVec3::select(cell.beyond.cmpeq(DVec3::ZERO), DVec3::ONE, DVec3::ZERO);
        SignedDistance {
            distance: cell.sum(&[]) + beyond,
            normal: slope * moves + cell.beyond / beyond,
        }
    }

    /// ∇²d: trilinear functions bend in mixed directions only, and beyond the grid the distance from its
    /// border bends as that from a face, an edge or a corner does.
    pub(super) fn curvature(&self, point: DVec3) -> DMat3 {
        let cell = self.cell(point);
        let inside = |k: usize| cell.beyond[k] == 0.0;
        let mixed = |i: usize, k: usize| match inside(i) && inside(k) {
            true => cell.sum(&[i, k]) / (self.spacing[i] * self.spacing[k]),
            false => 0.0,
        };
        let (xy, yz, zx) = (mixed(0, 1), mixed(1, 2), mixed(2, 0));
        let bent = DMat3::from_cols_array(&[0.0, xy, zx, xy, 0.0, yz, zx, yz, 0.0]);
        let beyond = cell.beyond.length();
        if beyond == 0.0 {
            return bent;
        }
        let n = cell.beyond / beyond;
        let free = DVec3::select(cell.beyond.cmpeq(DVec3::ZERO), DVec3::ZERO, DVec3::ONE);
        let outer = DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        bent + (DMat3::from_diagonal(free) - outer) * beyond.recip()
    }
}

impl Cell {
    /// Σ over corners of d_c Π_k (t_k or 1 − t_k), differentiated by the axes of `along`.
    fn sum(&self, along: &[usize]) -> f64 {
        let weight = |corner: usize| {
            let of_axis = |k: usize| match (corner >> k & 1 == 1, along.contains(&k)) {
                (true, false) => self.place[k],
                (false, false) => 1.0 - self.place[k],
                (true, true) => 1.0,
                (false, true) => -1.0,
            };
            of_axis(0) * of_axis(1) * of_axis(2)
        };
        (0..8).map(|c| weight(c) * self.corners[c]).sum()
    }
}

#[cfg(all(test, feature = "mesh-colliders"))]
mod tests {
    use super::*;
    use crate::math::Random;

    #[test]
    fn a_fine_ball_is_a_ball_to_the_stated_error() {
        let radius = 0.05;
        let ball = Shape::Sphere { radius };
        let grid = DistanceGrid::new(&ball.sampled(4000).unwrap()).unwrap();
        let s = grid.spacing.max_element();
        let random = &mut Random::new(3);
        for _ in 0..2000 {
            let point = random.vector(1.0).normalize() * random.uniform(0.6, 1.2) * radius;
            let (exact, found) = (ball.signed_distance(point), grid.signed_distance(point));
            // Two curved directions at radius |x|, and facets that lie inside the ball by e²/(8 r) at most, with
            // edges e of about 3 mm.
            let error = (found.distance - exact.distance).abs();
            assert!(
                error < s * s / (4.0 * 0.6 * radius) + 3e-5,
                "{point}: {error:e}"
            );
            assert!(found.normal.distance(exact.normal) < 0.1, "{point}");
            assert_eq!(found.distance < 0.0, exact.distance < -error, "{point}");
        }
    }

    #[test]
    fn unusable_meshes_are_refused() {
        let block = Shape::Box {
            half_extents: [0.1; 3],
        };
        let fails = |change: fn(&mut Surface)| {
            let mut surface = block.sampled(50).unwrap();
            change(&mut surface);
            DistanceGrid::new(&surface).unwrap_err().to_string()
        };
        assert!(fails(|s| s.triangles.clear()).contains("no triangle"));
        assert!(fails(|s| s.triangles.truncate(9)).contains("not closed"));
        assert!(
            fails(|s| s.triangles.iter_mut().for_each(|t| t.swap(0, 1))).contains("inside out")
        );
        assert!(fails(|s| s.positions[0].x = f64::NAN).contains("not finite"));
        assert!(fails(|s| s.triangles[0][0] = 9999).contains("not there"));
    }
}
