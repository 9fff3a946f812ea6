//! What a tet mesh is worth: volumes and dihedral angles.

use serde::{Deserialize, Serialize};
use std::fmt;
use supple::model::TetMesh;

/// Figures of a tet mesh. A regular tet has six dihedral angles of 70.5°.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MeshQuality {
    /// Number of nodes.
    pub nodes: usize,
    /// Number of tets.
    pub tets: usize,
    /// Tets of zero or negative volume.
    pub inverted: usize,
    /// Sum of the signed volumes, m³.
    pub volume: f64,
    /// Smallest signed volume, m³.
    pub smallest_volume: f64,
    /// Smallest dihedral angle, degrees.
    pub smallest_dihedral: f64,
    /// Median over the tets of each one's smallest dihedral angle, degrees.
    pub median_dihedral: f64,
    /// Largest dihedral angle, degrees.
    pub largest_dihedral: f64,
}

impl MeshQuality {
    /// Measures `mesh`; all zero for an empty one.
    pub fn of(mesh: &TetMesh) -> Self {
        let tets = mesh.tets.len();
        if tets == 0 {
            return Self::default();
        }
        let volumes: Vec<f64> = (0..tets).map(|t| mesh.volume(t)).collect();
        let angles: Vec<[f64; 6]> = (0..tets).map(|t| dihedral_angles(mesh, t)).collect();
        let least = |angles: &[f64; 6]| angles.iter().copied().fold(f64::INFINITY, f64::min);
        let mut smallest: Vec<f64> = angles.iter().map(least).collect();
        smallest.sort_by(f64::total_cmp);
        Self {
            nodes: mesh.nodes.len(),
            tets,
            inverted: volumes.iter().filter(|&&v| v <= 0.0).count(),
            volume: volumes.iter().sum(),
            smallest_volume: volumes.iter().copied().fold(f64::INFINITY, f64::min),
            smallest_dihedral: smallest[0].to_degrees(),
            median_dihedral: smallest[tets / 2].to_degrees(),
            largest_dihedral: angles
                .iter()
                .flatten()
                .copied()
                .fold(0.0, f64::max)
                .to_degrees(),
        }
    }
}

impl fmt::Display for MeshQuality {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} nodes, {} tets, {} inverted, {:.3} cm³, dihedral angles {:.1}° to {:.1}°, median of the smallest {:.1}°",
            self.nodes,
            self.tets,
            self.inverted,
            self.volume * 1e6,
            self.smallest_dihedral,
            self.largest_dihedral,
            self.median_dihedral
        )
    }
}

/// The six dihedral angles of tet `t`, rad: between faces i and j, cos = −∇λ_i · ∇λ_j / (|∇λ_i| |∇λ_j|),
/// since ∇λ_i is the inward normal of face i.
fn dihedral_angles(mesh: &TetMesh, t: usize) -> [f64; 6] {
    let normals = mesh.barycentric_gradients(t).map(|g| g.normalize_or_zero());
    [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]
        .map(|(i, j)| (-normals[i].dot(normals[j])).clamp(-1.0, 1.0).acos())
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use glam::DVec3;

    #[test]
    fn regular_and_corner_tets() {
        let regular = TetMesh {
            nodes: vec![
                DVec3::new(1.0, 1.0, 1.0),
                DVec3::new(-1.0, 1.0, -1.0),
                DVec3::new(1.0, -1.0, -1.0),
                DVec3::new(-1.0, -1.0, 1.0),
            ],
            tets: vec![[0, 1, 2, 3]],
        };
        let quality = MeshQuality::of(&regular);
        assert_relative_eq!(quality.volume.abs(), 8.0 / 3.0, max_relative = 1e-12);
        for angle in [quality.smallest_dihedral, quality.largest_dihedral] {
            assert_relative_eq!(
                angle,
                (1.0f64 / 3.0).acos().to_degrees(),
                max_relative = 1e-12
            );
        }
        let corner = TetMesh {
            nodes: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
            tets: vec![[0, 1, 2, 3], [0, 2, 1, 3]],
        };
        let quality = MeshQuality::of(&corner);
        assert_eq!(quality.inverted, 1);
        assert_relative_eq!(quality.largest_dihedral, 90.0, max_relative = 1e-12);
        assert_relative_eq!(
            quality.smallest_dihedral,
            (1.0 / 3.0f64.sqrt()).acos().to_degrees(),
            max_relative = 1e-12
        );
    }
}
