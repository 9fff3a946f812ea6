//! What cubature weights start from.

use super::cubature::{Tissue, Weights};
use crate::basis::{BasisEnergy, BiharmonicSystem, Constraints};
use crate::math::NearestPoint;
use glam::DVec3;
use supple::internal::math::par_map;
use supple::{Error, Result};

/// With a larger share of negative weights the positive ones are no use either.
const MOST_NEGATIVE: f64 = 0.03;

/// Positive weights to start from.
#[derive(Debug, PartialEq)]
pub(crate) struct Prior {
    /// One a point, m³.
    pub weights: Vec<f64>,
    /// How many biharmonic weights were negative.
    pub negative: usize,
    /// Whether they are all cells.
    pub cells: bool,
}

impl Prior {
    /// Those of points in `tets`.
    pub fn of(tissue: Tissue<'_>, weights: Weights, tets: &[u32]) -> Self {
        let cells = cell_volumes(tissue, tets);
        match weights {
            Weights::Cells => Self {
                weights: cells,
                negative: 0,
                cells: true,
            },
            // Points too dense for the mesh give a singular system.
            Weights::Biharmonic => {
                Self::of_biharmonic(biharmonic_weights(tissue, tets).unwrap_or_default(), cells)
            }
        }
    }

    /// The biharmonic weights `raw` with a cell in place of each negative one; or the cells alone where those are too
    /// many, or there are no weights at all.
    fn of_biharmonic(raw: Vec<f64>, cells: Vec<f64>) -> Self {
        let negative = raw.iter().filter(|w| **w <= 0.0).count();
        if raw.is_empty() || negative as f64 > MOST_NEGATIVE * raw.len() as f64 {
            return Self {
                weights: cells,
                negative,
                cells: true,
            };
        }
        let positive = |(w, cell): (f64, f64)| if w > 0.0 { w } else { cell };
        Self {
            weights: raw.into_iter().zip(cells).map(positive).collect(),
            negative,
            cells: false,
        }
    }
}

/// w_i = ∫ α_i, α_i the biharmonic coordinate of centroid i: \[A Cᵀ; C 0\]\[x; w\] = \[m; 0\], rows of C
/// being ¼ at a tet's nodes and m the nodal volumes.
fn biharmonic_weights(tissue: Tissue<'_>, tets: &[u32]) -> Result<Vec<f64>> {
    let centroids: Constraints = tets
        .iter()
        .map(|&t| tissue.mesh.tets[t as usize].map(|n| (n, 0.25)))
        .collect();
    let none = vec![false; tissue.mesh.nodes.len()];
    let system = BiharmonicSystem::new(tissue.mesh, BasisEnergy::Biharmonic, &none, &centroids)?;
    let weights = system.integrals(&tissue.nodal_volumes());
    if weights.iter().all(|w| w.is_finite()) {
        Ok(weights)
    } else {
        Err(Error::NotFinite {
            quantity: "cubature weights",
        })
    }
}

/// Tissue volume of the tets nearer to each point than to any other.
fn cell_volumes(tissue: Tissue<'_>, tets: &[u32]) -> Vec<f64> {
    let centroid = |&t: &u32| tissue.mesh.centroid(t as usize);
    let points: Vec<DVec3> = tets.iter().map(centroid).collect();
    let search = NearestPoint::new(&points);
    let nearest = par_map(tissue.mesh.tets.len(), |t| {
        let best = search.nearest(tissue.mesh.centroid(t));
        best.map_or(0, |(i, _)| i as usize)
    });
    let mut volumes = vec![0.0; points.len()];
    for (cell, volume) in nearest.into_iter().zip(tissue.tet_volumes()) {
        volumes[cell] += volume;
    }
    volumes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn negative_weights_become_cells_and_many_of_them_all_cells() {
        let cells: Vec<f64> = (0..100).map(|i| 1.0 + 0.01 * f64::from(i)).collect();
        let mut raw = vec![2.0; 100];
        raw[10..13].fill(-1.0);
        let prior = Prior::of_biharmonic(raw.clone(), cells.clone());
        assert_eq!((prior.negative, prior.cells), (3, false));
        assert_eq!((prior.weights[9], prior.weights[10]), (2.0, cells[10]));
        raw[13] = -1.0;
        let prior = Prior::of_biharmonic(raw, cells.clone());
        assert_eq!(
            (prior.weights, prior.negative, prior.cells),
            (cells.clone(), 4, true)
        );
        let none = Prior::of_biharmonic(Vec::new(), cells.clone());
        assert_eq!((none.weights, none.cells), (cells, true));
    }

    #[test]
    fn both_kinds_sum_to_the_volume_and_the_biharmonic_ones_have_its_first_moment() {
        let (mesh, fraction) = crate::test_mesh::partly_tissue();
        let tissue = Tissue {
            mesh: &mesh,
            fraction: &fraction,
        };
        let (volume, first) = tissue.moments();
        let tets: Vec<u32> = (0..40).map(|i| i * 49 + 3).collect();
        let weights = biharmonic_weights(tissue, &tets).unwrap();
        assert!((weights.iter().sum::<f64>() / volume - 1.0).abs() < 1e-12);
        let points = tets.iter().zip(&weights);
        let sum: DVec3 = points.map(|(&t, w)| *w * mesh.centroid(t as usize)).sum();
        assert!(
            (sum - first).length() < 1e-12 * volume * 0.1,
            "{}",
            sum - first
        );
        let cells = cell_volumes(tissue, &tets);
        assert!((cells.iter().sum::<f64>() / volume - 1.0).abs() < 1e-12);
        assert!(cells.iter().all(|w| *w > 0.0));
    }
}
