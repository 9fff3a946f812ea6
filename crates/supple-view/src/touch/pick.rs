//! What is under the cursor.

use crate::draw::Ray;
use glam::DVec3;

/// Where a ray meets a skin first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The nearest corner of the triangle there.
    pub vertex: usize,
    /// m.
    pub point: DVec3,
    /// Of the triangle, outward.
    pub normal: DVec3,
    /// From the eye, m.
    pub distance: f64,
}

/// The first of `triangles` of `positions` that `ray` meets from either side (Möller and Trumbore, "Fast, minimum storage
/// ray/triangle intersection", 1997).
pub fn pick(ray: &Ray, positions: &[DVec3], triangles: &[[u32; 3]]) -> Option<Hit> {
    let mut best: Option<(f64, [u32; 3])> = None;
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| positions[v as usize]);
        let (e, f) = (b - a, c - a);
        let p = ray.direction.cross(f);
        let det = e.dot(p);
        if det.abs() < 1e-18 {
            continue;
        }
        let s = (ray.origin - a) / det;
        let u = s.dot(p);
        let q = s.cross(e);
        let v = ray.direction.dot(q);
        let t = f.dot(q);
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        if inside && t > 0.0 && best.is_none_or(|(least, _)| t < least) {
            best = Some((t, *triangle));
        }
    }
    let (distance, triangle) = best?;
    let point = ray.at(distance);
    let corners = triangle.map(|v| positions[v as usize]);
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let nearer = |a: &u32, b: &u32| {
        let away = |v: u32| positions[v as usize].distance_squared(point);
        away(*a).total_cmp(&away(*b))
    };
    let vertex = triangle.into_iter().min_by(nearer)? as usize;
    Some(Hit {
        vertex,
        point,
        normal: normal.normalize_or_zero(),
        distance,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_triangle_and_its_nearest_corner_are_met() {
        let square = |z: f64| {
            [
                DVec3::new(0.0, 0.0, z),
                DVec3::new(1.0, 0.0, z),
                DVec3::new(0.0, 1.0, z),
            ]
        };
        let positions: Vec<_> = [square(0.0), square(0.5)].concat();
        let ray = Ray {
            origin: DVec3::new(0.6, 0.1, 2.0),
            direction: DVec3::NEG_Z,
        };
        let triangles = [[0, 1, 2], [3, 4, 5]];
        let hit = pick(&ray, &positions, &triangles).unwrap();
        assert_eq!((hit.vertex, hit.distance), (4, 1.5));
        assert!(hit.point.distance(DVec3::new(0.6, 0.1, 0.5)) < 1e-15);
        assert_eq!(hit.normal, DVec3::Z);
        let aside = Ray {
            origin: DVec3::new(0.6, 0.6, 2.0),
            ..ray
        };
        assert_eq!(pick(&aside, &positions, &triangles), None);
        let beyond = Ray {
            origin: DVec3::new(0.6, 0.1, -1.0),
            ..ray
        };
        assert_eq!(pick(&beyond, &positions, &triangles), None);
    }
}
