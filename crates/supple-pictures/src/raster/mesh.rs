//! What can be drawn.

use crate::colour::Colour;
use glam::DVec3;
use supple::collider::Shape;
use supple::model::{Frame, Surface};
use supple_files::solid_surface;

/// A surface ready to be drawn.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Its triangles; counter-clockwise seen from outside.
    pub surface: Surface,
    /// Unit normal of each vertex.
    pub normals: Vec<DVec3>,
    /// Colour of each vertex.
    pub colours: Vec<Colour>,
    /// Colour of the cut face where the clipping plane opens it; `None`: it is left whole.
    pub cut: Option<Colour>,
}

/// A plane that hides everything on the side its normal points to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A point of it, m.
    pub point: DVec3,
    /// Towards the hidden side.
    pub normal: DVec3,
}

impl Plane {
    /// Signed distance of `x`, positive on the hidden side.
    pub fn distance(&self, x: DVec3) -> f64 {
        (x - self.point).dot(self.normal.normalize_or(DVec3::Z))
    }
}

impl Mesh {
    /// A surface of one colour.
    pub fn new(surface: Surface, colour: Colour) -> Self {
        let colours = vec![colour; surface.positions.len()];
        Self {
            normals: surface.vertex_normals(),
            colours,
            surface,
            cut: None,
        }
    }

    /// A surface with a colour at each vertex.
    pub fn coloured(surface: Surface, colours: Vec<Colour>) -> Self {
        Self {
            normals: surface.vertex_normals(),
            colours,
            surface,
            cut: None,
        }
    }

    /// The same mesh, opened by the clipping plane and filled with `colour` there.
    pub fn opened(mut self, colour: Colour) -> Self {
        self.cut = Some(colour);
        self
    }

    /// A collider; `extent` is half the side of the square drawn for a half-space.
    pub fn collider(shape: &Shape, frame: &Frame, extent: f64, colour: Colour) -> Self {
        let mut surface = solid_surface(shape, extent);
        (surface.positions.iter_mut()).for_each(|p| *p = frame.transform(*p));
        Self::new(surface, colour)
    }
}

/// Balls (centre, radius, colour) as one mesh of few triangles each.
pub fn point_cloud(balls: impl Iterator<Item = (DVec3, f64, Colour)>) -> Mesh {
    let unit = ball();
    let mut mesh = Mesh::new(Surface::default(), [0.0; 3]);
    for (centre, radius, colour) in balls {
        let first = mesh.surface.positions.len() as u32;
        for n in &unit.positions {
            mesh.surface.positions.push(centre + radius * *n);
            mesh.normals.push(*n);
            mesh.colours.push(colour);
        }
        let triangles = unit.triangles.iter().map(|t| t.map(|v| v + first));
        mesh.surface.triangles.extend(triangles);
    }
    mesh
}

/// The unit ball as an octahedron whose triangles are split twice: 66 vertices.
fn ball() -> Surface {
    const SPLITS: u32 = 4;
    let mut surface = Surface::default();
    let mut index = std::collections::HashMap::new();
    let mut vertex = |corner: [i64; 3], surface: &mut Surface| {
        *index.entry(corner).or_insert_with(|| {
            let place = DVec3::from_array(corner.map(|c| c as f64));
            surface.positions.push(place.normalize_or(DVec3::Z));
            surface.positions.len() as u32 - 1
        })
    };
    for octant in 0..8u32 {
        let sign = [0, 1, 2].map(|bit| if octant >> bit & 1 == 0 { 1 } else { -1 });
        let inward = sign.iter().product::<i64>() < 0;
        // Barycentric grid points (i, j, SPLITS − i − j) of the face.
        let at = |i: u32, j: u32| {
            let grid = [i, j, SPLITS - i - j].map(i64::from);
            [0, 1, 2].map(|k| sign[k] * grid[k])
        };
        for i in 0..SPLITS {
            for j in 0..SPLITS - i {
                let mut faces = vec![[at(i + 1, j), at(i, j + 1), at(i, j)]];
                if i + j + 1 < SPLITS {
                    faces.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
                for [a, b, c] in faces {
                    let [a, b, c] = [a, b, c].map(|p| vertex(p, &mut surface));
                    (surface.triangles).push(if inward { [a, c, b] } else { [a, b, c] });
                }
            }
        }
    }
    surface
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn balls_are_octahedra_split_twice() {
        let octahedra = point_cloud([(DVec3::X, 2.0, [0.5; 3])].into_iter()).surface;
        assert!(octahedra.is_closed() && octahedra.positions.len() == 66);
        let ball = 4.0 / 3.0 * PI * 8.0;
        assert!((0.9..1.0).contains(&(octahedra.volume() / ball)));
    }
}
