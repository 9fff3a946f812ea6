//! The skin's mesh: the left half of the implicit body, remeshed, and its mirror image.

use super::anatomy::mirrored;
use super::shape::BodyShape;
use crate::model::Surface;
use crate::sample::polygonise::polygonise;
use crate::sample::remesh::{Implicit, remesh_half};
use crate::{Error, Result};
use glam::DVec3;

/// Vertices of the skin, as many as SMPL's; 2 V − 4 = 13,776 triangles.
pub(super) const VERTICES: usize = 6890;

/// Side of a grid cell, mm, and its part along each axis around the hand.
const CELL: f64 = 7.0;
const FINE: f64 = 0.36;
/// Where the cells are fine: from and to, for x, y and z. Only the hand lies in all three.
const FINE_RANGE: [[f64; 2]; 3] = [[655.0, 900.0], [1270.0, 1400.0], [-110.0, 80.0]];

/// A closed surface that is its own mirror image.
#[derive(Clone, Debug)]
pub(super) struct Skin {
    /// Its mesh, mm.
    pub surface: Surface,
    /// The vertex across the plane of symmetry, itself on the plane.
    pub twin: Vec<u32>,
}

/// Coordinate of a grid plane: steps are [`FINE`] times shorter in the range.
fn warped(u: f64, [from, to]: [f64; 2]) -> f64 {
    let fine = (u - from).clamp(0.0, (to - from) / FINE);
    u - (1.0 - FINE) * fine
}

/// The closed skin.
pub(super) fn skin(shape: &BodyShape) -> Result<Skin> {
    let place = |u: DVec3| {
        DVec3::new(
            warped(u.x, FINE_RANGE[0]),
            warped(u.y, FINE_RANGE[1]),
            warped(u.z, FINE_RANGE[2]),
        )
    };
    let longer = |k: usize| (FINE_RANGE[k][1] - FINE_RANGE[k][0]) * (1.0 / FINE - 1.0);
    let low = DVec3::new(0.0, -15.0, -170.0);
    let high = DVec3::new(905.0 + longer(0), 1735.0 + longer(1), 215.0 + longer(2));
    let (positions, triangles) = polygonise(low, high, CELL, |u| shape.distance(place(u)));
    let positions = positions.into_iter().map(place).collect();
    let (positions, triangles) = remesh_half(shape, positions, triangles, VERTICES);
    let skin = with_mirror_image(positions, triangles);
    if skin.surface.positions.len() != VERTICES || !skin.surface.is_closed() {
        let problem = format!(
            "{} vertices after remeshing, not {VERTICES}, or not closed",
            skin.surface.positions.len()
        );
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
