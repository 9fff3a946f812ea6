//! The skin's mesh: the left half of the implicit body, remeshed, and its mirror image.

use super::anatomy::mirrored;
use super::shape::BodyShape;
use crate::field::smoothstep;
use crate::polygonise::polygonise;
use crate::remesh::{Implicit, remesh_half};
use glam::DVec3;
use supple::model::Surface;
use supple::{Error, Result};

/// Vertices of the skin, as many as SMPL's; 2 V − 4 = 13,776 triangles.
pub(super) const VERTICES: usize = 6890;

/// Side of a grid cell, mm, and its part along each axis around the hand.
const CELL: f64 = 8.0;
const FINE: f64 = 0.25;
/// What the grid covers, mm.
const LOW: DVec3 = DVec3::new(0.0, -15.0, -170.0);
const HIGH: DVec3 = DVec3::new(905.0, 1735.0, 215.0);
/// Where cells are fine: a box around the hand.
const FINE_LOW: DVec3 = DVec3::new(640.0, 1265.0, -110.0);
const FINE_HIGH: DVec3 = DVec3::new(905.0, 1395.0, 85.0);
/// Over this way along x the cells of the trunk give way to those of the hand.
const TURN: [f64; 2] = [520.0, 640.0];

/// A closed surface that is its own mirror image.
#[derive(Clone, Debug)]
pub(super) struct Skin {
    /// Its mesh, mm.
    pub surface: Surface,
    /// The vertex across the plane of symmetry, itself on the plane.
    pub twin: Vec<u32>,
}

/// How much longer the grid is than what it covers.
fn longer() -> DVec3 {
    (FINE_HIGH - FINE_LOW) * (1.0 / FINE - 1.0)
}

/// Place of the grid's coordinates `u`: steps along x are [`FINE`] times shorter beside the hand, those along
/// y and z near it; elsewhere they are even.
fn place(u: DVec3) -> DVec3 {
    let fine = (u - FINE_LOW).clamp(DVec3::ZERO, (FINE_HIGH - FINE_LOW) / FINE);
    let warped = u - (1.0 - FINE) * fine;
    let even = LOW + (u - LOW) * (HIGH - LOW) / (HIGH + longer() - LOW);
    let turn = smoothstep((warped.x - TURN[0]) / (TURN[1] - TURN[0]));
    let mixed = even.lerp(warped, turn);
    DVec3::new(warped.x, mixed.y, mixed.z)
}

/// The closed skin.
pub(super) fn skin(shape: &BodyShape) -> Result<Skin> {
    let (positions, triangles) =
        polygonise(LOW, HIGH + longer(), CELL, |u| shape.distance(place(u)));
    let positions = positions.into_iter().map(place).collect();
    let (positions, triangles) = remesh_half(shape, positions, triangles, VERTICES);
    let skin = with_mirror_image(positions, triangles);
    let (vertices, triangles) = (skin.surface.positions.len(), skin.surface.triangles.len());
    // Euler: a closed surface with a handle, as fused fingers make, has more triangles.
    if vertices != VERTICES || triangles != 2 * VERTICES - 4 {
        let problem = format!("{vertices} vertices and {triangles} triangles after remeshing");
        return Err(Error::invalid("sample body", problem));
    }
    Ok(skin)
}

/// A half, open on x = 0, and its image beyond that plane.
fn with_mirror_image(mut positions: Vec<DVec3>, mut triangles: Vec<[u32; 3]>) -> Skin {
    let half = positions.len();
    let mut twin: Vec<u32> = (0..half as u32).collect();
    for v in 0..half {
        if positions[v].x != 0.0 {
            twin[v] = positions.len() as u32;
            twin.push(v as u32);
            positions.push(mirrored(positions[v]));
        }
    }
    let images: Vec<[u32; 3]> = (triangles.iter())
        .map(|&[a, b, c]| [a, c, b].map(|v| twin[v as usize]))
        .collect();
    triangles.extend(images);
    Skin {
        surface: Surface {
            positions,
            triangles,
        },
        twin,
    }
}
