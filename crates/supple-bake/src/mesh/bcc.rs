//! The body-centred cubic lattice and its tets.
//!
//! Nodes are the corners and the centres of cubic cells. For every two cells that share a face, four
//! tets join their centres with the face's four edges; all tets are congruent, with dihedral angles
//! of 60° and 90° and a volume of cell³/12 (Labelle and Shewchuk 2007).

use glam::DVec3;

/// A box of cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BccLattice {
    /// Corner (0, 0, 0), m.
    pub origin: DVec3,
    /// Edge of a cell, m.
    pub cell: f64,
    /// Cells along x, y, z.
    pub counts: [usize; 3],
}

impl BccLattice {
    /// Covers the box `low`..`high` with a cell to spare on every side.
    pub fn covering(low: DVec3, high: DVec3, cell: f64) -> Self {
        // Not a round fraction of a cell, so that flat skins do not coincide with lattice planes.
        let origin = low - cell * DVec3::new(1.37, 1.41, 1.45);
        let counts = ((high - origin) / cell + 1.5).ceil().to_array();
        Self {
            origin,
            cell,
            counts: counts.map(|n| n as usize),
        }
    }

    fn cell_index(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.counts[0] * (j + self.counts[1] * k)
    }

    fn corner_index(&self, [i, j, k]: [usize; 3]) -> usize {
        i + (self.counts[0] + 1) * (j + (self.counts[1] + 1) * k)
    }

    fn corners(&self) -> usize {
        self.counts.iter().map(|n| n + 1).product()
    }

    /// Node number of the corner at `at`.
    pub fn corner_node(&self, at: [usize; 3]) -> u32 {
        self.corner_index(at) as u32
    }

    /// Node number of the centre of cell `at`.
    pub fn centre_node(&self, at: [usize; 3]) -> u32 {
        (self.corners() + self.cell_index(at)) as u32
    }

    /// Place of a node, m.
    pub fn node_position(&self, node: u32) -> DVec3 {
        let split = |index: usize, [nx, ny, _]: [usize; 3]| {
            DVec3::new(
                (index % nx) as f64,
                (index / nx % ny) as f64,
                (index / (nx * ny)) as f64,
            )
        };
        let (node, corners) = (node as usize, self.corners());
        let steps = if node < corners {
            split(node, self.counts.map(|n| n + 1))
        } else {
            split(node - corners, self.counts) + 0.5
        };
        self.origin + self.cell * steps
    }

    /// The tet of a place within cell `at`, `offset` from its centre in cells.
    ///
    /// Number: 12 cell + 4 axis + edge, of the lower of the two cells that share a face along the
    /// axis; the edges lie on the +b, −b, +c and −c side of the face, b and c following the axis.
    pub fn tet_at(&self, at: [usize; 3], offset: [f64; 3]) -> u32 {
        let size = offset.map(f64::abs);
        let axis = match size {
            [x, y, z] if x >= y && x >= z => 0,
            [_, y, z] if y >= z => 1,
            _ => 2,
        };
        let mut lower = at;
        if offset[axis] < 0.0 {
            lower[axis] -= 1;
        }
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let edge = if size[b] >= size[c] {
            usize::from(offset[b] < 0.0)
        } else {
            2 + usize::from(offset[c] < 0.0)
        };
        (12 * self.cell_index(lower) + 4 * axis + edge) as u32
    }

    /// The tet that holds `point`, which lies in the covered box.
    pub fn locate(&self, point: DVec3) -> u32 {
        let u = ((point - self.origin) / self.cell).to_array();
        let at = [0, 1, 2].map(|a| (u[a].floor().max(1.0) as usize).min(self.counts[a] - 2));
        self.tet_at(at, [0, 1, 2].map(|a| u[a] - at[a] as f64 - 0.5))
    }

    /// The four nodes of a tet, positively oriented.
    pub fn tet_nodes(&self, tet: u32) -> [u32; 4] {
        let (cell, axis, edge) = (tet as usize / 12, tet as usize % 12 / 4, tet as usize % 4);
        let [nx, ny, _] = self.counts;
        let lower = [cell % nx, cell / nx % ny, cell / (nx * ny)];
        let mut upper = lower;
        upper[axis] += 1;
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        // Counter-clockwise about the axis.
        let ends = [
            [(1, 0), (1, 1)],
            [(0, 1), (0, 0)],
            [(1, 1), (0, 1)],
            [(0, 0), (1, 0)],
        ][edge];
        let corner = |(along_b, along_c): (usize, usize)| {
            let mut corner = upper;
            corner[b] += along_b;
            corner[c] += along_c;
            self.corner_node(corner)
        };
        [
            self.centre_node(lower),
            self.centre_node(upper),
            corner(ends[0]),
            corner(ends[1]),
        ]
    }
}

/// Corners (of the first, of the second) that two tets have in common.
pub(super) fn shared_corners(a: &[u32; 4], b: &[u32; 4]) -> impl Iterator<Item = (usize, usize)> {
    (a.iter().enumerate())
        .filter_map(|(i, node)| b.iter().position(|other| other == node).map(|j| (i, j)))
}

/// Whether two tets share a face.
pub(super) fn share_face(a: &[u32; 4], b: &[u32; 4]) -> bool {
    shared_corners(a, b).count() == 3
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use supple::model::TetMesh;

    #[test]
    fn a_located_tet_holds_its_point() {
        let lattice = BccLattice::covering(DVec3::ZERO, DVec3::new(1.0, 0.7, 0.5), 0.1);
        let mut seen = std::collections::BTreeSet::new();
        for i in 0..20_000 {
            // A low-discrepancy sequence over the box.
            let step = i as f64 * DVec3::new(0.8191725134, 0.6710436067, 0.5497004779);
            let point = step.fract() * DVec3::new(1.0, 0.7, 0.5);
            let tet = lattice.locate(point);
            let mesh = TetMesh {
                nodes: lattice
                    .tet_nodes(tet)
                    .map(|n| lattice.node_position(n))
                    .into(),
                tets: vec![[0, 1, 2, 3]],
            };
            assert_relative_eq!(
                mesh.volume(0),
                lattice.cell.powi(3) / 12.0,
                max_relative = 1e-9
            );
            let inside = mesh.barycentric(0, point);
            assert!(
                inside.iter().all(|l| (-1e-9..=1.0).contains(l)),
                "{inside:?}"
            );
            seen.insert(tet % 12);
        }
        assert_eq!(seen.len(), 12);
    }
}
