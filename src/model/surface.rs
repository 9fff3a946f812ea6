//! Triangle surfaces.

use crate::math::Rows;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A triangle mesh, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Surface {
    /// Vertex positions, m.
    pub positions: Vec<DVec3>,
    /// Three vertices each.
    pub triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Corner positions of triangle `t`.
    pub fn corners(&self, t: usize) -> [DVec3; 3] {
        self.triangles[t].map(|v| self.positions[v as usize])
    }

    /// Lowest and highest corner of the box around all vertices, m; 0 where there is none.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let corner = |pick: fn(DVec3, DVec3) -> DVec3| self.positions.iter().copied().reduce(pick);
        let (low, high) = (corner(DVec3::min), corner(DVec3::max));
        (low.unwrap_or_default(), high.unwrap_or_default())
    }

    /// Area vector (area × unit normal) of triangle `t`, m².
    pub fn area_vector(&self, t: usize) -> DVec3 {
        let [a, b, c] = self.corners(t);
        0.5 * (b - a).cross(c - a)
    }

    /// The triangles around each vertex, rising.
    pub fn triangles_around(&self) -> Rows<u32> {
        let mut around = vec![Vec::new(); self.positions.len()];
        for (t, triangle) in self.triangles.iter().enumerate() {
            triangle
                .iter()
                .for_each(|&v| around[v as usize].push(t as u32));
        }
        around.into_iter().collect()
    }

    /// A third of the area of the triangles around each vertex, m².
    pub fn vertex_areas(&self) -> Vec<f64> {
        let mut areas = vec![0.0; self.positions.len()];
        for (t, triangle) in self.triangles.iter().enumerate() {
            let share = self.area_vector(t).length() / 3.0;
            triangle.iter().for_each(|&v| areas[v as usize] += share);
        }
        areas
    }

    /// Area-weighted unit normal of each vertex; zero where there is none.
    pub fn vertex_normals(&self) -> Vec<DVec3> {
        let mut normals = vec![DVec3::ZERO; self.positions.len()];
        for (t, triangle) in self.triangles.iter().enumerate() {
            let area = self.area_vector(t);
            triangle.iter().for_each(|&v| normals[v as usize] += area);
        }
        normals.into_iter().map(DVec3::normalize_or_zero).collect()
    }

    /// Volume enclosed by a closed surface, m³ (divergence theorem).
    pub fn volume(&self) -> f64 {
        (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t);
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }

    /// Whether every directed edge is matched by exactly one opposite edge.
    pub fn is_closed(&self) -> bool {
        let mut edges = std::collections::HashMap::new();
        for &[a, b, c] in &self.triangles {
            for edge in [(a, b), (b, c), (c, a)] {
                *edges.entry(edge).or_insert(0u32) += 1;
            }
        }
        !edges.is_empty()
            && edges
                .iter()
                .all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1))
    }
}
