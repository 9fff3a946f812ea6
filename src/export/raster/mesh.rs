//! What can be drawn.

use crate::collider::Shape;
use crate::export::Colour;
use crate::model::{Frame, Surface};
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

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
        let mut surface = match *shape {
            Shape::HalfSpace => grid(extent),
            Shape::Mesh(ref mesh) => mesh
                .grid()
                .map_or_else(|_| Surface::default(), |grid| grid.surface().clone()),
            Shape::Sphere { radius } => revolve(&arc(radius, 0.0, -0.5 * PI, 0.5 * PI)),
            Shape::Capsule {
                radius,
                half_length,
            } => {
                let mut profile = arc(radius, -half_length, -0.5 * PI, 0.0);
                profile.extend(arc(radius, half_length, 0.0, 0.5 * PI));
                revolve(&profile)
            }
            Shape::Cylinder {
                radius,
                half_length,
            } => {
                // Repeated profile points part the vertices, so that the rims stay sharp.
                let (low, high) = (
                    DVec2::new(radius, -half_length),
                    DVec2::new(radius, half_length),
                );
                let ends = [DVec2::new(0.0, -half_length), DVec2::new(0.0, half_length)];
                revolve(&[ends[0], low, low, high, high, ends[1]])
            }
            Shape::Box { half_extents } => cuboid(DVec3::from_array(half_extents)),
        };
        surface
            .positions
            .iter_mut()
            .for_each(|p| *p = frame.transform(*p));
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

/// Points (distance from the axis, height) of a quarter or half circle, from angle `from` to `to`.
fn arc(radius: f64, height: f64, from: f64, to: f64) -> Vec<DVec2> {
    const SEGMENTS: usize = 32;
    (0..=SEGMENTS)
        .map(|i| {
            let angle = from + (to - from) * i as f64 / SEGMENTS as f64;
            DVec2::new(radius * angle.cos().max(0.0), height + radius * angle.sin())
        })
        .collect()
}

/// The surface swept by a profile (distance, height), rising, about z.
fn revolve(profile: &[DVec2]) -> Surface {
    const SEGMENTS: u32 = 96;
    let ring = |p: &DVec2| {
        let (r, z) = (p.x, p.y);
        (0..SEGMENTS).map(move |k| {
            let (sin, cos) = (TAU * f64::from(k) / f64::from(SEGMENTS)).sin_cos();
            DVec3::new(r * cos, r * sin, z)
        })
    };
    let positions = profile.iter().flat_map(ring).collect();
    let mut triangles = Vec::new();
    for (row, pair) in profile.windows(2).enumerate() {
        if pair[0] == pair[1] {
            continue;
        }
        for k in 0..SEGMENTS {
            let base = row as u32 * SEGMENTS;
            let (a, b) = (base + k, base + (k + 1) % SEGMENTS);
            let (c, d) = (a + SEGMENTS, b + SEGMENTS);
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    Surface {
        positions,
        triangles,
    }
}

/// A square of side 2 `extent` in the plane z = 0, in cells small enough to cross the camera's side.
fn grid(extent: f64) -> Surface {
    const CELLS: u32 = 32;
    let at = |i: u32| extent * (2.0 * f64::from(i) / f64::from(CELLS) - 1.0);
    let mut surface = Surface::default();
    for j in 0..=CELLS {
        for i in 0..=CELLS {
            surface.positions.push(DVec3::new(at(i), at(j), 0.0));
            if i < CELLS && j < CELLS {
                let a = j * (CELLS + 1) + i;
                let (b, c, d) = (a + 1, a + CELLS + 1, a + CELLS + 2);
                surface.triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
    }
    surface
}

/// A box with sharp edges: each face has its own corners.
fn cuboid(half: DVec3) -> Surface {
    let mut surface = Surface::default();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut n = DVec3::ZERO;
            n[axis] = sign;
            let mut u = DVec3::ZERO;
            u[(axis + 1) % 3] = 1.0;
            let v = n.cross(u);
            let first = surface.positions.len() as u32;
            for (s, t) in [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)] {
                surface.positions.push((n + s * u + t * v) * half);
            }
            let [a, b, c, d] = [first, first + 1, first + 2, first + 3];
            surface.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    surface
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn solids_enclose_their_volume() {
        let volume = |shape: Shape| {
            Mesh::collider(&shape, &Frame::IDENTITY, 1.0, [0.5; 3])
                .surface
                .volume()
        };
        let (r, l) = (0.3, 0.5);
        let sphere = 4.0 / 3.0 * PI * r * r * r;
        let tube = PI * r * r * 2.0 * l;
        // 96 chords a turn lose (2π/96)²/6 of a circle's area, and 32 chords from pole to pole (π/32)²/4 of
        // a ball's volume: 3.13e-3 together.
        let relative = |a: f64, b: f64| assert_relative_eq!(a, b, max_relative = 3.2e-3);
        relative(volume(Shape::Sphere { radius: r }), sphere);
        let (radius, half_length) = (r, l);
        relative(
            volume(Shape::Cylinder {
                radius,
                half_length,
            }),
            tube,
        );
        relative(
            volume(Shape::Capsule {
                radius,
                half_length,
            }),
            tube + sphere,
        );
        let octahedra = point_cloud([(DVec3::X, 2.0, [0.5; 3])].into_iter()).surface;
        assert!(octahedra.is_closed() && octahedra.positions.len() == 66);
        let ball = 4.0 / 3.0 * PI * 8.0;
        assert!((0.9..1.0).contains(&(octahedra.volume() / ball)));
        let half_extents = [0.1, 0.2, 0.3];
        assert_relative_eq!(volume(Shape::Box { half_extents }), 0.048, epsilon = 1e-12);
    }
}
