//! Normals of the drawn skin: area-weighted over the triangles around each vertex.

use crate::math::Rows;
use glam::DVec3;

/// Triangles around each vertex, each as (the vertex's two successors in it), rising by triangle.
pub fn vertex_triangles(vertices: usize, triangles: &[[u32; 3]]) -> Rows<[u32; 2]> {
    let mut rows = vec![Vec::new(); vertices];
    for &[a, b, c] in triangles {
        rows[a as usize].push([b, c]);
        rows[b as usize].push([c, a]);
        rows[c as usize].push([a, b]);
    }
    rows.into_iter().collect()
}

/// Σ (x_b − x) × (x_c − x), normalised; 0 where the triangles have no area.
pub fn normal(positions: &[DVec3], vertex: usize, around: &[[u32; 2]]) -> DVec3 {
    let x = positions[vertex];
    let area: DVec3 = around
        .iter()
        .map(|&[b, c]| (positions[b as usize] - x).cross(positions[c as usize] - x))
        .sum();
    area.normalize_or_zero()
}
