//! The solid inside a closed triangle mesh: d interpolated between samples of its signed distance.
//!
//! At the nodes of a grid around the mesh d is exact; between them it is trilinear, which misses a smooth
//! d by at most ⅛ Σ s_k² |∂²d/∂x_k²| with spacings s (a ball of radius r: s²/(4 r)), and rounds edges and
//! corners off within a cell. Beyond the grid d grows with the distance from it.
//!
//! n is the exact gradient of that interpolant and no unit vector: its length is 1 up to the same error. Contact
//! needs the gradient, since E = ½ k a (d̂ − d)₊² pushes with −∂E/∂x = k a (d̂ − d)₊ ∇d, whatever ∇d's length; made a
//! unit vector it would be the gradient of no energy. Only friction needs a plane: it takes ∇d/|∇d|, and λ is
//! the length of the push ([`crate::reference::compact::lag`]). Both twins do the same.

use super::SignedDistance;
use crate::math::par_map;
use crate::model::Surface;
use crate::{Error, Result};
use glam::{DMat3, DVec3, IVec3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::{TriMesh, TriMeshFlags};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Nodes of a grid along each axis: 432 KiB a mesh.
pub const MESH_NODES: usize = 48;

/// Cells between the mesh and the grid's border.
const BORDER: f64 = 4.0;

/// A mesh as a collider's shape: of a surface, or of a file that a scene names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshShape {
    /// An OBJ file whose objects are closed surfaces; empty where the surface was given.
    pub file: PathBuf,
    #[serde(skip)]
    grid: Option<Arc<DistanceGrid>>,
}

/// A closed surface and its signed distance at the nodes of a grid.
#[derive(Clone, PartialEq)]
pub struct DistanceGrid {
    surface: Surface,
    /// The node of least coordinates, m.
    low: DVec3,
    /// From a node to the next, m.
    spacing: DVec3,
    /// d, m, as both evaluations have it; x runs fastest.
    values: Vec<f32>,
}

impl fmt::Debug for DistanceGrid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let triangles = self.surface.triangles.len();
        write!(f, "DistanceGrid of {triangles} triangles")
    }
}

impl MeshShape {
    /// The solid inside `surface`.
    ///
    /// # Errors
    /// As [`DistanceGrid::new`].
    pub fn new(surface: &Surface) -> Result<Self> {
        Ok(Self {
            file: PathBuf::new(),
            grid: Some(Arc::new(DistanceGrid::new(surface)?)),
        })
    }

    /// The solid that a scene's file holds; it keeps the file's name.
    pub(crate) fn with_surface(&self, path: &Path, surface: &Surface) -> Result<Self> {
        Ok(Self {
            file: path.into(),
            ..Self::new(surface)?
        })
    }

    /// Its distances.
    ///
    /// # Errors
    /// [`Error::Invalid`] of a file that was not read: [`crate::load::read_scene`] reads it.
    pub fn grid(&self) -> Result<&Arc<DistanceGrid>> {
        self.grid.as_ref().ok_or_else(|| {
            let problem = format!(
                "{} was not read: load::read_scene reads a scene's meshes, load::parse_scene opens no file, and \
                 MeshShape::new takes a surface",
                self.file.display()
            );
            Error::invalid("collider.shape.file", problem)
        })
    }

    pub(super) fn signed_distance(&self, point: DVec3) -> SignedDistance {
        match &self.grid {
            Some(grid) => grid.signed_distance(point),
            // Refused before any step.
            None => SignedDistance {
                distance: f64::MAX,
                normal: DVec3::Z,
            },
        }
    }

    pub(super) fn curvature(&self, point: DVec3) -> DMat3 {
        (self.grid.as_ref()).map_or(DMat3::ZERO, |grid| grid.curvature(point))
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
    /// Samples the signed distance from a closed `surface`, triangles counter-clockwise from outside.
    ///
    /// # Errors
    /// [`Error::Invalid`] of a surface that is empty, open, inside out or not finite.
    pub fn new(surface: &Surface) -> Result<Self> {
        let refuse = |problem: &str| Err(Error::invalid("collider.shape.mesh", problem));
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
            .map_err(|e| Error::invalid("collider.shape.mesh", e.to_string()))?;
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
            let distance = |i: usize| {
                let p = vector(&node(i));
                let nearest = mesh.project_local_point(p, false);
                let length = (nearest.point - p).length();
                (if nearest.is_inside { -length } else { length }) as f32
            };
            (0..n * n).map(distance).collect()
        };
        Ok(Self {
            surface: surface.clone(),
            low,
            spacing,
            values: par_map(n, slice).concat(),
        })
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
    fn signed_distance(&self, point: DVec3) -> SignedDistance {
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
    fn curvature(&self, point: DVec3) -> DMat3 {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collider::Shape;
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
        let unread: MeshShape = toml::from_str("file = \"a.obj\"").unwrap();
        assert!(unread.grid().unwrap_err().to_string().contains("a.obj"));
    }
}
