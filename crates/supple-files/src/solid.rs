//! Surfaces of solids as they are drawn: finely, with sharp edges.

use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};
use supple::collider::Shape;
use supple::model::Surface;

/// The surface of `shape` in its own frame; `extent` is half the side of the square that stands for a half-space, m.
pub fn solid_surface(shape: &Shape, extent: f64) -> Surface {
    match *shape {
        Shape::HalfSpace => grid(extent),
        Shape::Mesh(ref mesh) => mesh.grid().surface().clone(),
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
    }
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
        let volume = |shape: Shape| solid_surface(&shape, 1.0).volume();
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
        let half_extents = [0.1, 0.2, 0.3];
        assert_relative_eq!(volume(Shape::Box { half_extents }), 0.048, epsilon = 1e-12);
    }
}
