//! Closed surfaces of solids, evenly sampled: what a rigid body touches with.

use super::Shape;
use super::mass::no_solid;
use crate::Result;
use crate::model::Surface;
use glam::{DVec3, IVec3};
use std::collections::HashMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Points around the axis at one height.
#[derive(Clone, Copy)]
struct Ring {
    points: u32,
    radius: f64,
    height: f64,
}

impl Shape {
    /// The closed surface with about `vertices` vertices, all of them on it and evenly spread; a mesh's own.
    ///
    /// # Errors
    /// [`crate::Error::Invalid`] of a half-space: it has no bounds.
    pub fn sampled(&self, vertices: usize) -> Result<Surface> {
        // A vertex stands for about the square of its distance from the next one.
        let spacing = |area: f64| (area / vertices.max(8) as f64).sqrt();
        let steps = |length: f64, spacing: f64| (length / spacing).round().max(1.0) as u32;
        Ok(match *self {
            Self::HalfSpace => return Err(no_solid()),
            Self::Mesh(ref mesh) => mesh.grid().surface().clone(),
            Self::Sphere { radius } => {
                let s = spacing(4.0 * PI * radius * radius);
                rings(&dome(radius, 0.0, steps(radius * FRAC_PI_2, s).max(2)), 0)
            }
            Self::Capsule {
                radius,
                half_length,
            } => {
                let s = spacing(4.0 * PI * radius * (radius + half_length));
                let cap = dome(radius, half_length, steps(radius * FRAC_PI_2, s).max(2));
                rings(&cap, steps(2.0 * half_length, s))
            }
            Self::Cylinder {
                radius,
                half_length,
            } => {
                let s = spacing(TAU * radius * (radius + 2.0 * half_length));
                rings(
                    &disc(radius, half_length, steps(radius, s).max(2)),
                    steps(2.0 * half_length, s),
                )
            }
            Self::Box { half_extents } => {
                let half = DVec3::from_array(half_extents);
                let s = spacing(8.0 * (half.x * half.y + half.y * half.z + half.z * half.x));
                cuboid(half, half.to_array().map(|h| steps(2.0 * h, s) as i32))
            }
        })
    }
}

/// Six more points a ring: as far apart along a ring as rings are.
fn count(ring: u32) -> u32 {
    (6 * ring).max(1)
}

/// A flat end of `n` rings at `height`, from its middle.
fn disc(radius: f64, height: f64, n: u32) -> Vec<Ring> {
    let ring = |i: u32| Ring {
        points: count(i),
        radius: radius * f64::from(i) / f64::from(n),
        height,
    };
    (0..=n).map(ring).collect()
}

/// Half a ball above `height`, from its pole.
fn dome(radius: f64, height: f64, n: u32) -> Vec<Ring> {
    let ring = |i: u32| {
        let (sine, cosine) = (FRAC_PI_2 * f64::from(i) / f64::from(n)).sin_cos();
        Ring {
            points: count(i),
            radius: radius * sine,
            height: height + if i == n { 0.0 } else { radius * cosine },
        }
    };
    (0..=n).map(ring).collect()
}

/// A solid of revolution about z: `end` above, its mirror image below, and `rows` rows of triangles
/// between their rims; without any the rims are one.
fn rings(end: &[Ring], rows: u32) -> Surface {
    let below = |r: &Ring| Ring {
        height: -r.height,
        ..*r
    };
    let mut all: Vec<Ring> = end.iter().map(below).collect();
    let rim = end[end.len() - 1];
    all.extend((1..=rows).map(|k| Ring {
        height: rim.height * (2.0 * f64::from(k) / f64::from(rows) - 1.0),
        ..rim
    }));
    all.extend(end.iter().rev().skip(1));
    let mut surface = Surface::default();
    for (k, ring) in all.iter().enumerate() {
        let first = surface.positions.len() as u32;
        for i in 0..ring.points {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(ring.points)).sin_cos();
            let place = DVec3::new(ring.radius * cos, ring.radius * sin, ring.height);
            surface.positions.push(place);
        }
        if k > 0 {
            let lower = all[k - 1].points;
            stitch(
                (first - lower, lower),
                (first, ring.points),
                &mut surface.triangles,
            );
        }
    }
    surface
}

/// Triangles between a lower and an upper ring, each (first vertex, number): whichever ring's next
/// point comes first around the axis goes on.
fn stitch(lower: (u32, u32), upper: (u32, u32), out: &mut Vec<[u32; 3]>) {
    let at = |ring: (u32, u32), i: u32| ring.0 + i % ring.1;
    // A pole stays.
    let steps = |ring: (u32, u32)| if ring.1 == 1 { 0 } else { ring.1 };
    let (mut i, mut j) = (0, 0);
    while i < steps(lower) || j < steps(upper) {
        let lower_first = (i + 1) * upper.1 <= (j + 1) * lower.1;
        if j == steps(upper) || (i < steps(lower) && lower_first) {
            out.push([at(lower, i), at(lower, i + 1), at(upper, j)]);
            i += 1;
        } else {
            out.push([at(lower, i), at(upper, j + 1), at(upper, j)]);
            j += 1;
        }
    }
}

/// A box in `cells` along x, y, z.
fn cuboid(half: DVec3, cells: [i32; 3]) -> Surface {
    let cells = IVec3::from_array(cells);
    let mut surface = Surface::default();
    let mut index = HashMap::new();
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for far in [false, true] {
            let mut vertex = |i: i32, j: i32| {
                let mut corner = IVec3::ZERO;
                (corner[axis], corner[u], corner[v]) = (if far { cells[axis] } else { 0 }, i, j);
                *index.entry(corner).or_insert_with(|| {
                    let part = corner.as_dvec3() / cells.as_dvec3();
                    surface.positions.push(half * (2.0 * part - 1.0));
                    surface.positions.len() as u32 - 1
                })
            };
            for i in 0..cells[u] {
                for j in 0..cells[v] {
                    let [a, b, c, d] =
                        [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(di, dj)| vertex(i + di, j + dj));
                    let faces = if far {
                        [[a, b, c], [a, c, d]]
                    } else {
                        [[a, c, b], [a, d, c]]
                    };
                    surface.triangles.extend(faces);
                }
            }
        }
    }
    surface
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::BoneMass;
    use approx::assert_relative_eq;

    #[test]
    fn surfaces_are_closed_lie_on_the_solid_and_are_even() {
        // A mesh has its own vertices.
        let exact = |s: &Shape| !matches!(s, Shape::Mesh(_));
        for shape in Shape::examples().into_iter().filter(exact) {
            let Ok(surface) = shape.sampled(300) else {
                assert_eq!(shape, Shape::HalfSpace);
                continue;
            };
            let count = surface.positions.len();
            assert!((150..500).contains(&count), "{shape:?}: {count} vertices");
            assert!(surface.is_closed(), "{shape:?}");
            for p in &surface.positions {
                assert!(
                    shape.signed_distance(*p).distance.abs() < 1e-15,
                    "{shape:?} {p}"
                );
            }
            // Edges of a box are half as wide in one direction, corners in two.
            let areas = surface.vertex_areas();
            let mean = areas.iter().sum::<f64>() / count as f64;
            let widest = areas.iter().fold(0.0, |a: f64, b| a.max(*b));
            let least = areas.iter().fold(f64::INFINITY, |a: f64, b| a.min(*b));
            assert!(
                widest < 2.5 * mean && least > 0.2 * mean,
                "{shape:?}: {least} {mean} {widest}"
            );
        }
    }

    #[test]
    fn analytic_moments_are_those_of_a_fine_surface() {
        for shape in Shape::examples() {
            let Ok(exact) = shape.mass(700.0) else {
                continue;
            };
            let fine = shape.sampled(20_000).unwrap();
            let sampled = BoneMass::of_surface(&fine, DVec3::ZERO, 700.0);
            for i in 0..4 {
                // An inscribed polyhedron of 20,000 vertices lacks under 0.1 % of a ball's volume, and by
                // the fifth power of its size twice that of its moments.
                let (found, wanted) = (sampled.second_moment[i][i], exact.second_moment[i][i]);
                assert_relative_eq!(found, wanted, max_relative = 2e-3);
            }
        }
        let radius = 0.03;
        let ball = Shape::Sphere { radius }.mass(700.0).unwrap();
        let s = ball.second_moment;
        // I_zz = ∫ρ (x² + y²) = 2/5 m r².
        let inertia = s[0][0] + s[1][1];
        assert_relative_eq!(
            inertia,
            0.4 * ball.mass() * radius * radius,
            max_relative = 1e-14
        );
    }
}
