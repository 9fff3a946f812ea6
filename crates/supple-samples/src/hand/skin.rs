//! The skin's mesh, from the implicit hand.

use super::shape::HandShape;
use crate::polygonise::polygonise;
use crate::remesh::{Implicit, remesh};
use glam::DVec3;
use supple::model::Surface;
use supple::{Error, Result};

/// Vertices of the skin, as many as the hand of Tapia et al. (2021) has; 2 V − 4 = 6,208 triangles.
pub(super) const VERTICES: usize = 3106;

/// The closed skin, mm.
pub(super) fn skin(shape: &HandShape) -> Result<Surface> {
    let (positions, triangles) = polygonise(
        DVec3::new(-36.0, -72.0, -52.0),
        DVec3::new(200.0, 100.0, 34.0),
        2.4,
        |p| shape.distance(p),
    );
    let (positions, triangles) = remesh(shape, positions, triangles, VERTICES);
    if positions.len() != VERTICES {
        let problem = format!(
            "{} vertices after remeshing, not {VERTICES}",
            positions.len()
        );
        return Err(Error::invalid("sample hand", problem));
    }
    Ok(Surface {
        positions,
        triangles,
    })
}
