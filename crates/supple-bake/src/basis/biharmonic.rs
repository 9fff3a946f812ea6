//! The sparse biharmonic basis (Wang, Jacobson, Barbič and Kavan 2015).

use super::biharmonic_energy::BasisEnergy;
use crate::math::{DenseFactor, SparseFactor, SparseSymmetric};
use crate::mesh::{add_laplacian, loose_tets};
use glam::DVec3;
use supple::internal::math::{Rows, par_map};
use supple::model::TetMesh;
use supple::{Error, Result};

/// A linear condition on the nodes: Σ share · u = value. A node has one share of 1, a point inside
/// a tet its four barycentric coordinates.
pub type Constraints = Rows<(u32, f64)>;

/// Minimises ½ uᵀ A u where fixed nodes and constraints have given values.
///
/// With K = A + ρ CᵀC over the free nodes (definite where fixed nodes and constraints span the
/// affine functions, with the same constrained minimum and no more fill, since a row of C stays in
/// one tet), u = K⁻¹ (f + Cᵀ S⁻¹ (c − C K⁻¹ f)), S = C K⁻¹ Cᵀ, f = −A_bᵀ u_b of the
/// fixed nodes b.
#[derive(Debug)]
pub struct BiharmonicSystem {
    /// Column of each node in the system; `None` where it is fixed.
    pub(super) column_of_node: Vec<Option<u32>>,
    /// Number of columns.
    free: usize,
    /// Tets whose part of the mesh fixed nodes and constraints do not determine.
    loose_tets: usize,
    /// Nodes with a tet that is not loose.
    determined: Vec<bool>,
    /// Energy entries between a free and a fixed node: (free column, fixed node, value).
    coupling: Vec<(u32, u32, f64)>,
    /// Shares of each constraint on free nodes, by column.
    pub(super) constraints: Constraints,
    /// The same on fixed nodes, by node.
    constraints_on_fixed: Constraints,
    pub(super) factor: SparseFactor,
    /// The columns of K⁻¹ Cᵀ.
    solved: Vec<Vec<f64>>,
    /// S.
    pub(super) schur: DenseFactor,
}

impl BiharmonicSystem {
    const NAME: &'static str = "biharmonic basis";

    /// Factors the system of `mesh` with the nodes of `fixed` held.
    ///
    /// # Errors
    /// [`Error::Invalid`] where a length or index is off; [`Error::Solve`] where the fixed nodes and
    /// constraints do not determine the mesh, or repeat one another.
    pub fn new(
        mesh: &TetMesh,
        energy: BasisEnergy,
        fixed: &[bool],
        constraints: &Constraints,
    ) -> Result<Self> {
        Self::factored(mesh, energy, fixed, constraints, true)
    }

    /// The same; without `keep` it has no K⁻¹ Cᵀ, and only [`super::ManyColumns`] can use it.
    pub(super) fn factored(
        mesh: &TetMesh,
        energy: BasisEnergy,
        fixed: &[bool],
        constraints: &Constraints,
        keep: bool,
    ) -> Result<Self> {
        let all_constraints = constraints;
        let nodes = mesh.nodes.len();
        if fixed.len() != nodes {
            return Err(Error::invalid("fixed", "one flag is needed for each node"));
        }
        if constraints.entries().iter().any(|e| e.0 as usize >= nodes) {
            return Err(Error::invalid(
                "constraints",
                "names a node that is not there",
            ));
        }
        let mut free = 0;
        let column_of_node: Vec<Option<u32>> = fixed
            .iter()
            .map(|&f| {
                (!f).then(|| {
                    free += 1;
                    free - 1
                })
            })
            .collect();
        let part = |on_fixed: bool| -> Constraints {
            constraints
                .iter()
                .map(|row| {
                    row.iter().filter_map(|&(node, share)| {
                        match (column_of_node[node as usize], on_fixed) {
                            (Some(column), false) => Some((column, share)),
                            (None, true) => Some((node, share)),
                            _ => None,
                        }
                    })
                })
                .collect()
        };
        let (constraints, constraints_on_fixed) = (part(false), part(true));

        let mut coupling = Vec::new();
        let mut entries = Vec::new();
        let mut trace = 0.0;
        let mut energy = energy.entries(mesh);
        let loose = loose_tets(mesh, fixed, all_constraints);
        if 2 * loose.len() > mesh.tets.len() {
            let problem = "fixed nodes and constraints do not determine the mesh".into();
            let system = Self::NAME;
            return Err(Error::Solve { system, problem });
        }
        add_laplacian(mesh, &loose, &mut energy);
        let mut determined = vec![false; nodes];
        for (t, tet) in mesh.tets.iter().enumerate() {
            let sound = loose.binary_search(&(t as u32)).is_err();
            tet.iter().for_each(|&n| determined[n as usize] |= sound);
        }
        for (row, column, value) in energy {
            match (
                column_of_node[row as usize],
                column_of_node[column as usize],
            ) {
                (Some(r), Some(c)) => {
                    trace += if r == c { value } else { 0.0 };
                    entries.push((r, c, value));
                }
                (Some(r), None) => coupling.push((r, column, value)),
                (None, Some(c)) => coupling.push((c, row, value)),
                (None, None) => {}
            }
        }
        let penalty = trace / f64::from(free.max(1));
        for row in constraints.iter() {
            for &(i, share_i) in row {
                for &(j, share_j) in row.iter().filter(|e| e.0 <= i) {
                    entries.push((i, j, penalty * share_i * share_j));
                }
            }
        }
        let matrix = SparseSymmetric::from_entries(free as usize, &entries);
        drop(entries);
        let factor = SparseFactor::new(&matrix, Self::NAME)?;
        let (solved, schur): (Vec<_>, Vec<_>) = factor
            .solve_each(
                constraints.len(),
                |i, b| scatter(constraints.row(i), 1.0, b),
                |_, z| {
                    (
                        if keep { z.to_vec() } else { Vec::new() },
                        gather(&constraints, z),
                    )
                },
            )
            .into_iter()
            .unzip();
        let schur = DenseFactor::new(&schur, "constraints of the biharmonic basis")?;
        Ok(Self {
            column_of_node,
            free: free as usize,
            loose_tets: loose.len(),
            determined,
            coupling,
            constraints,
            constraints_on_fixed,
            factor,
            solved,
            schur,
        })
    }

    /// Tets in parts that hang on the rest by an edge or a corner only, and hold too few fixed nodes
    /// and constraints to be determined: a faint Laplacian keeps those still.
    pub fn loose_tets(&self) -> usize {
        self.loose_tets
    }

    /// The minimiser (one value a node) with `fixed_values` at the fixed nodes (other entries are
    /// not read) and `values` at the constraints.
    pub fn minimise(&self, fixed_values: &[f64], values: &[f64]) -> Vec<f64> {
        let mut load = vec![0.0; self.free];
        self.load(fixed_values, &mut load);
        self.constrained(self.factor.solve(&load), fixed_values, values)
    }

    /// f = −A_bᵀ u_b.
    fn load(&self, fixed_values: &[f64], load: &mut [f64]) {
        for &(column, node, value) in &self.coupling {
            load[column as usize] -= value * fixed_values[node as usize];
        }
    }

    /// The minimiser from the one without constraints, K⁻¹ f.
    fn constrained(&self, mut u: Vec<f64>, fixed_values: &[f64], values: &[f64]) -> Vec<f64> {
        let missing: Vec<f64> = gather(&self.constraints, &u)
            .into_iter()
            .zip(gather(&self.constraints_on_fixed, fixed_values))
            .zip(values)
            .map(|((reached, held), value)| value - held - reached)
            .collect();
        for (z, multiplier) in self.solved.iter().zip(self.schur.solve(&missing)) {
            add_scaled(z, multiplier, &mut u);
        }
        self.on_nodes(&u, fixed_values)
    }

    /// Column h is 1 at constraint h and 0 at the others and at the fixed nodes: one column a
    /// constraint, one value a node.
    pub fn basis(&self) -> Vec<Vec<f64>> {
        let count = self.constraints.len();
        let zeros = vec![0.0; self.column_of_node.len()];
        par_map(count, |h| {
            let mut unit = vec![0.0; count];
            unit[h] = 1.0;
            let mut u = vec![0.0; self.free];
            for (z, multiplier) in self.solved.iter().zip(self.schur.solve(&unit)) {
                add_scaled(z, multiplier, &mut u);
            }
            self.on_nodes(&u, &zeros)
        })
    }

    /// The multipliers w of \[A Cᵀ; C 0\] \[x; w\] = \[m; 0\]: each constraint's integral of its
    /// column of [`BiharmonicSystem::basis`] against the nodal measure `m` (free nodes only).
    pub fn integrals(&self, measure: &[f64]) -> Vec<f64> {
        let mut load = vec![0.0; self.free];
        for (column, &m) in self.column_of_node.iter().zip(measure) {
            if let Some(c) = column {
                load[*c as usize] = m;
            }
        }
        self.schur
            .solve(&gather(&self.constraints, &self.factor.solve(&load)))
    }

    /// How well `columns` (of [`BiharmonicSystem::basis`]) and the fixed nodes' own affine columns
    /// reproduce 1 and the coordinates: the largest |Σ_h U_h f(X_h) + U_fixed f − f| over the nodes
    /// of tets that are not loose, in units of the mesh's size. Rounding, unless the constraints do not determine the mesh.
    pub fn linear_precision(&self, mesh: &TetMesh, columns: &[Vec<f64>]) -> f64 {
        let nodes = &mesh.nodes;
        let low = nodes.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = nodes.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let (centre, size) = ((low + high) / 2.0, (high - low).max_element());
        let affine = |axis: usize| -> Vec<f64> {
            let value = |x: &DVec3| match axis {
                0..3 => (x[axis] - centre[axis]) / size,
                _ => 1.0,
            };
            nodes.iter().map(value).collect()
        };
        let exact: [Vec<f64>; 4] = std::array::from_fn(affine);
        let none = vec![0.0; self.constraints.len()];
        let of_fixed = self.factor.solve_each(
            4,
            |axis, load| self.load(&exact[axis], load),
            |axis, u| self.constrained(u.to_vec(), &exact[axis], &none),
        );
        let error = |(exact, mut sum): (&Vec<f64>, Vec<f64>)| {
            let at_handles = gather(&self.constraints, &self.free_part(exact)).into_iter();
            let at_handles = at_handles.zip(gather(&self.constraints_on_fixed, exact));
            for (column, (free, held)) in columns.iter().zip(at_handles) {
                add_scaled(column, free + held, &mut sum);
            }
            let differences = (sum.iter().zip(exact).zip(&self.determined))
                .filter(|(_, determined)| **determined)
                .map(|((s, e), _)| (s - e).abs());
            differences.fold(0.0, |m: f64, d| if d > m || d.is_nan() { d } else { m })
        };
        (exact.iter().zip(of_fixed))
            .map(error)
            .fold(0.0, |m: f64, e| if e > m || e.is_nan() { e } else { m })
    }

    /// Values of the free nodes by column.
    fn free_part(&self, on_nodes: &[f64]) -> Vec<f64> {
        let columns = self.column_of_node.iter().zip(on_nodes);
        columns.filter_map(|(c, &u)| c.map(|_| u)).collect()
    }

    fn on_nodes(&self, u: &[f64], fixed_values: &[f64]) -> Vec<f64> {
        self.column_of_node
            .iter()
            .zip(fixed_values)
            .map(|(column, &held)| column.map_or(held, |c| u[c as usize]))
            .collect()
    }
}

/// x += scale · z.
fn add_scaled(z: &[f64], scale: f64, x: &mut [f64]) {
    x.iter_mut().zip(z).for_each(|(x, z)| *x += scale * z);
}

/// x += scale · Cᵀ row.
pub(crate) fn scatter(row: &[(u32, f64)], scale: f64, x: &mut [f64]) {
    row.iter()
        .for_each(|&(i, share)| x[i as usize] += scale * share);
}

/// C x.
pub(crate) fn gather(constraints: &Constraints, x: &[f64]) -> Vec<f64> {
    let sum = |row: &[(u32, f64)]| row.iter().map(|&(i, share)| share * x[i as usize]).sum();
    constraints.iter().map(sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_mesh::jittered_box;
    use supple::internal::math::Random;

    /// A box whose lowest layer of nodes is bone, with handles at nodes and inside tets.
    fn sample(seed: u64) -> (TetMesh, Vec<bool>, Constraints) {
        let mesh = jittered_box([5, 4, 3], 0.01, 0.15, seed);
        let fixed: Vec<bool> = (0..mesh.nodes.len()).map(|n| n < 6 * 5).collect();
        let mut random = Random::new(seed + 1);
        let mut constraints = Constraints::default();
        let nodes = mesh.nodes.len();
        for third in 0..4 {
            // Spread over the upper layers, so that no node is drawn twice.
            let node = 30 + third * 22 + (random.uniform(0.0, 1.0) * 22.0) as usize;
            constraints.push([(node.min(nodes - 1) as u32, 1.0)]);
        }
        for part in 0..4 {
            let tet = (part as f64 + random.uniform(0.0, 1.0)) / 4.0 * mesh.tets.len() as f64;
            let mut shares = [0; 4].map(|_| 0.1 + random.uniform(0.0, 1.0));
            let sum: f64 = shares.iter().sum();
            shares.iter_mut().for_each(|s| *s /= sum);
            constraints.push(mesh.tets[tet as usize].into_iter().zip(shares));
        }
        (mesh, fixed, constraints)
    }

    #[test]
    fn basis_interpolates_and_vanishes_at_bones() {
        let (mesh, fixed, constraints) = sample(3);
        for energy in [BasisEnergy::Biharmonic, BasisEnergy::Triharmonic] {
            let system = BiharmonicSystem::new(&mesh, energy, &fixed, &constraints).unwrap();
            for (h, column) in system.basis().iter().enumerate() {
                for (k, reached) in gather(&constraints, column).into_iter().enumerate() {
                    let error = reached - f64::from(u8::from(h == k));
                    assert!(error.abs() < 1e-10, "{energy:?}: U_{h} at {k}: {reached}");
                }
                assert!((0..fixed.len()).all(|n| !fixed[n] || column[n] == 0.0));
            }
        }
    }

    #[test]
    fn partition_and_linear_precision_with_the_bones_affine_columns() {
        let energies = [BasisEnergy::Biharmonic, BasisEnergy::Triharmonic];
        for (seed, energy) in (11..14).flat_map(|seed| energies.map(|e| (seed, e))) {
            let (mesh, fixed, constraints) = sample(seed);
            let system = BiharmonicSystem::new(&mesh, energy, &fixed, &constraints).unwrap();
            let basis = system.basis();
            let precision = system.linear_precision(&mesh, &basis);
            assert!(precision < 1e-9, "{energy:?}, seed {seed}: {precision:e}");
            // The measure sees a column that is off by a hundredth.
            let mut broken = basis.clone();
            broken[2].iter_mut().for_each(|u| *u *= 1.01);
            assert!(system.linear_precision(&mesh, &broken) > 1e-3);
        }
    }

    #[test]
    fn too_few_constraints_are_a_typed_error() {
        let (mesh, _, constraints) = sample(5);
        let three: Constraints = constraints.iter().take(3).map(<[_]>::to_vec).collect();
        let error = BiharmonicSystem::new(
            &mesh,
            BasisEnergy::Biharmonic,
            &vec![false; mesh.nodes.len()],
            &three,
        );
        assert!(matches!(error, Err(Error::Solve { .. })), "{error:?}");
    }
}
