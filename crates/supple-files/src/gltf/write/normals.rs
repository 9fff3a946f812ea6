//! What a displacement does to normals.

use glam::DVec3;
use supple::model::Surface;

/// First-order change of the vertex normals: δn = (I − n nᵀ) δa / |a|, a the sum of the area vectors of
/// the triangles around the vertex.
pub(super) fn normal_change(surface: &Surface, displacement: &[DVec3]) -> Vec<DVec3> {
    let count = surface.positions.len();
    let (mut area, mut change) = (vec![DVec3::ZERO; count], vec![DVec3::ZERO; count]);
    for (t, triangle) in surface.triangles.iter().enumerate() {
        let [x, y, z] = surface.corners(t);
        let [dx, dy, dz] = triangle.map(|v| displacement[v as usize]);
        let (a, d) = (
            (y - x).cross(z - x),
            (dy - dx).cross(z - x) + (y - x).cross(dz - dx),
        );
        for &v in triangle {
            area[v as usize] += a;
            change[v as usize] += d;
        }
    }
    area.iter()
        .zip(&change)
        .map(|(a, d)| {
            let n = a.normalize_or_zero();
            let length = a.length().max(f64::MIN_POSITIVE);
            (*d - n * n.dot(*d)) / length
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_change_to_first_order() {
        let ball = supple::collider::Shape::Sphere { radius: 0.1 };
        let surface = crate::solid_surface(&ball, 1.0);
        let bend = |p: &DVec3| DVec3::new(p.y * p.z, 0.3 * p.x, -p.x * p.y);
        let field: Vec<_> = surface.positions.iter().map(bend).collect();
        let moved = |scale: f64| Surface {
            positions: surface
                .positions
                .iter()
                .zip(&field)
                .map(|(p, d)| *p + scale * *d)
                .collect(),
            triangles: surface.triangles.clone(),
        };
        let step = 1e-5;
        let (plus, minus) = (moved(step).vertex_normals(), moved(-step).vertex_normals());
        let change = normal_change(&surface, &field);
        let mut largest: f64 = 0.0;
        for v in 0..field.len() {
            let expected = (plus[v] - minus[v]) / (2.0 * step);
            largest = largest.max(expected.length());
            let found = change[v];
            assert!(
                (found - expected).length() < 1e-5,
                "vertex {v}: {found} {expected}"
            );
        }
        assert!(largest > 0.1, "the field turns normals");
    }
}
