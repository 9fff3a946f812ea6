//! Tetrahedral meshes.

use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// Nodes and positively oriented tetrahedra: det(x₁−x₀, x₂−x₀, x₃−x₀) > 0.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TetMesh {
    /// Node positions, m.
    pub nodes: Vec<DVec3>,
    /// Four nodes each.
    pub tets: Vec<[u32; 4]>,
}

impl TetMesh {
    /// Corner positions of tet `t`.
    pub fn corners(&self, t: usize) -> [DVec3; 4] {
        self.tets[t].map(|n| self.nodes[n as usize])
    }

    /// Edge matrix (x₁−x₀, x₂−x₀, x₃−x₀) of tet `t`.
    pub fn edges(&self, t: usize) -> DMat3 {
        let [a, b, c, d] = self.corners(t);
        DMat3::from_cols(b - a, c - a, d - a)
    }

    /// Signed volume of tet `t`, m³.
    pub fn volume(&self, t: usize) -> f64 {
        self.edges(t).determinant() / 6.0
    }

    /// Mean of the corners of tet `t`.
    pub fn centroid(&self, t: usize) -> DVec3 {
        self.corners(t).iter().sum::<DVec3>() / 4.0
    }

    /// ∇λ of the four barycentric coordinates of tet `t`, 1/m.
    pub fn barycentric_gradients(&self, t: usize) -> [DVec3; 4] {
        let inverse = self.edges(t).inverse().transpose();
        let (b, c, d) = (inverse.col(0), inverse.col(1), inverse.col(2));
        [-(b + c + d), b, c, d]
    }

    /// Barycentric coordinates of `point` in tet `t`; all are in 0..1 inside it.
    pub fn barycentric(&self, t: usize, point: DVec3) -> [f64; 4] {
        let local = self.edges(t).inverse() * (point - self.nodes[self.tets[t][0] as usize]);
        [1.0 - local.x - local.y - local.z, local.x, local.y, local.z]
    }

    /// Faces of tet `t`, outward, face `i` opposite to corner `i`.
    pub fn faces(&self, t: usize) -> [[u32; 3]; 4] {
        let [a, b, c, d] = self.tets[t];
        [[b, c, d], [a, d, c], [a, b, d], [a, c, b]]
    }

    /// Faces that belong to one tet only, outward, in the order of their tets.
    pub fn boundary_triangles(&self) -> Vec<[u32; 3]> {
        let mut faces: Vec<([u32; 3], u32)> = (0..self.tets.len())
            .flat_map(|t| {
                self.faces(t)
                    .into_iter()
                    .enumerate()
                    .map(move |(i, mut face)| {
                        face.sort_unstable();
                        (face, (4 * t + i) as u32)
                    })
            })
            .collect();
        faces.sort_unstable();
        let mut single: Vec<u32> = faces
            .chunk_by(|a, b| a.0 == b.0)
            .filter(|twins| twins.len() == 1)
            .map(|twins| twins[0].1)
            .collect();
        single.sort_unstable();
        single
            .into_iter()
            .map(|f| self.faces(f as usize / 4)[f as usize % 4])
            .collect()
    }
}
