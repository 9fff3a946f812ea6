//! The columns of many handles, too many to hold them all in full.

use super::biharmonic::{BiharmonicSystem, Constraints, scatter};
use super::{BasisEnergy, Truncation};
use std::ops::Range;
use supple::Result;
use supple::model::TetMesh;

/// The system of [`BiharmonicSystem`] with two solves a column in place of a table of K⁻¹ Cᵀ, which would be as large as
/// all columns together: u_h = K⁻¹ Cᵀ w_h with w_h = S⁻¹ e_h, where S = C K⁻¹ Cᵀ took the first solves.
#[derive(Debug)]
pub(crate) struct ManyColumns(BiharmonicSystem);

impl ManyColumns {
    /// Factors the system of `mesh` with the nodes of `fixed` held.
    ///
    /// # Errors
    /// As [`BiharmonicSystem::new`].
    pub fn new(
        mesh: &TetMesh,
        energy: BasisEnergy,
        fixed: &[bool],
        constraints: &Constraints,
    ) -> Result<Self> {
        let system = BiharmonicSystem::factored(mesh, energy, fixed, constraints, false)?;
        Ok(Self(system))
    }

    /// The columns `which` (1 at their own constraint, 0 at the others and at fixed nodes), each truncated to (node, u), nodes
    /// rising.
    pub fn truncated(&self, which: Range<usize>, truncation: &Truncation) -> Vec<Vec<(u32, f64)>> {
        let Self(system) = self;
        let load = |i: usize, b: &mut [f64]| {
            let mut unit = vec![0.0; system.constraints.len()];
            unit[which.start + i] = 1.0;
            let multipliers = system.schur.solve(&unit);
            for (row, multiplier) in system.constraints.iter().zip(multipliers) {
                scatter(row, multiplier, b);
            }
        };
        let kept = |_: usize, u: &[f64]| {
            let nodes = system.column_of_node.iter().zip(0..);
            let value = |(column, node): (&Option<u32>, u32)| {
                let u = truncation.apply(u[(*column)? as usize]);
                (u != 0.0).then_some((node, u))
            };
            nodes.filter_map(value).collect()
        };
        system.factor.solve_each(which.len(), load, kept)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_mesh::jittered_box;

    #[test]
    fn columns_are_those_of_the_full_system() {
        let mesh = jittered_box([5, 4, 3], 0.01, 0.15, 7);
        let fixed: Vec<bool> = (0..mesh.nodes.len()).map(|n| n < 30).collect();
        let mut constraints: Constraints =
            [31, 52, 70, 95].map(|n| [(n, 1.0)]).into_iter().collect();
        let shares = [0.1, 0.4, 0.3, 0.2];
        constraints.push(mesh.tets[mesh.tets.len() - 3].into_iter().zip(shares));
        let energy = BasisEnergy::Biharmonic;
        let whole = BiharmonicSystem::new(&mesh, energy, &fixed, &constraints).unwrap();
        let whole = whole.basis();
        let many = ManyColumns::new(&mesh, energy, &fixed, &constraints).unwrap();
        for (h, column) in many.truncated(2..5, &Truncation::OFF).iter().enumerate() {
            for (n, expected) in whole[2 + h].iter().enumerate() {
                let at = column.iter().find(|e| e.0 as usize == n);
                let error = at.map_or(0.0, |e| e.1) - expected;
                assert!(error.abs() < 1e-10, "column {h} at {n}: off by {error:e}");
            }
        }
        let truncation = Truncation::default();
        for (h, column) in many.truncated(2..5, &truncation).iter().enumerate() {
            let kept = whole[2 + h].iter().filter(|u| truncation.apply(**u) != 0.0);
            assert_eq!(column.len(), kept.count());
            assert!(column.len() < mesh.nodes.len() - 30);
        }
    }
}
