//! The skin's mesh, from the implicit hand.

use super::polygonise::polygonise;
use super::remesh::{Implicit, remesh};
use super::shape::HandShape;
use crate::model::Surface;
use glam::DVec3;

/// Vertices of the skin: MANO's count plus what closes the wrist is near it; 2 V − 4 triangles.
pub(super) const VERTICES: usize = 3106;

impl Implicit for HandShape {
    fn project(&self, p: DVec3) -> DVec3 {
        HandShape::project(self, p)
    }

    fn edge_length(&self, p: DVec3) -> f64 {
        // Finer on digits, and finer still towards their tips; the wrist needs little.
        let (digit, distance) = self.nearest_digit(p);
        let sweep = &self.digits[digit];
        let [_, tip] = sweep.range();
        let along = (sweep.axes.local(p).x / tip).clamp(0.0, 1.0);
        let on_digit = (1.0 - distance / 10.0).clamp(0.0, 1.0);
        let fine = 3.3 - 1.0 * along;
        let palm = 4.4 + 1.6 * (-p.x / 25.0).clamp(0.0, 1.0);
        palm + (fine - palm) * on_digit
    }
}

/// The closed skin, mm.
pub(super) fn skin(shape: &HandShape) -> Surface {
    let (positions, triangles) = polygonise(
        DVec3::new(-36.0, -72.0, -52.0),
        DVec3::new(200.0, 100.0, 34.0),
        2.4,
        |p| shape.distance(p),
    );
    let (positions, triangles) = remesh(shape, positions, triangles, VERTICES);
    Surface {
        positions,
        triangles,
    }
}
