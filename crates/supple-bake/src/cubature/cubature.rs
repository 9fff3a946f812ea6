//! Data-oblivious cubature: points spread over the tissue that stand for all of it (Tapia et al. 2021, §4.2).

use crate::cubature::points::{candidates, sample, squared_slopes};
use crate::cubature::prior::Prior;
use crate::cubature::weights::{Moments, nearest_weights};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use supple::internal::math::Rows;
use supple::model::TetMesh;
use supple::{Error, Result};

/// The part of a layer's tets that is tissue.
#[derive(Clone, Copy, Debug)]
pub struct Tissue<'a> {
    /// The tets.
    pub mesh: &'a TetMesh,
    /// The tissue part of each tet, in (0, 1].
    pub fraction: &'a [f64],
}

impl Tissue<'_> {
    /// Tissue volume of each tet, m³.
    pub fn tet_volumes(&self) -> Vec<f64> {
        (self.fraction.iter().enumerate())
            .map(|(t, fraction)| fraction * self.mesh.volume(t))
            .collect()
    }

    /// A quarter of the tissue volume of the tets around each node, m³.
    pub fn nodal_volumes(&self) -> Vec<f64> {
        let mut nodal = vec![0.0; self.mesh.nodes.len()];
        for (tet, volume) in self.mesh.tets.iter().zip(self.tet_volumes()) {
            tet.iter().for_each(|&n| nodal[n as usize] += volume / 4.0);
        }
        nodal
    }

    /// Zeroth and first moment of the tissue: m³ and m⁴.
    pub(crate) fn moments(&self) -> (f64, DVec3) {
        let volumes = self.tet_volumes();
        let first = volumes.iter().enumerate();
        (
            volumes.iter().sum(),
            first.map(|(t, v)| *v * self.mesh.centroid(t)).sum(),
        )
    }
}

/// Tets that stand for the whole tissue.
#[derive(Clone, Debug, PartialEq)]
pub struct Cubature {
    /// The tets; a point is the centroid of one.
    pub tets: Vec<u32>,
    /// w of each, m³, all positive; Σ w and Σ w X are the tissue's.
    pub weights: Vec<f64>,
    /// How it went.
    pub report: CubatureReport,
}

/// What became of the cubature's weights.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CubatureReport {
    /// Points.
    pub points: usize,
    /// Tissue volume, m³.
    pub volume: f64,
    /// Σ w, m³.
    pub weight_sum: f64,
    /// Negative biharmonic weights; their points took their cell's volume instead.
    pub negative_weights: usize,
    /// Whether every weight started from its point's cell.
    pub cells: bool,
    /// Root mean square over the handles of the relative error of ∫ s |∇U|², before the weights were
    /// corrected for it and after.
    pub stiffness_error: [f64; 2],
    /// Whether every tet became a point.
    pub all_tets: bool,
}

/// Fewer tets than this a point, and every tet is a point.
const TETS_PER_POINT: usize = 4;
/// How points are placed and weighted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CubatureMethod {
    /// Where points are dense.
    pub sampling: Sampling,
    /// What a point's weight starts from.
    pub weights: Weights,
    /// Whether weights are corrected, as little as possible, to keep each handle's ∫ s |∇U|² too, besides
    /// volume and first moment; s is the recipe's map of the stiffness.
    pub keep_stiffness: bool,
}

impl Default for CubatureMethod {
    fn default() -> Self {
        Self {
            sampling: Sampling::Stiffness,
            weights: Weights::Cells,
            keep_stiffness: true,
        }
    }
}

impl CubatureMethod {
    /// Uniform points with biharmonic weights, as published.
    pub const PAPER: Self = Self {
        sampling: Sampling::Uniform,
        weights: Weights::Biharmonic,
        keep_stiffness: false,
    };
}

/// Where cubature points are dense.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sampling {
    /// Where handles make the tissue stiff: as Σ_h |∇U_h|².
    #[default]
    Stiffness,
    /// The same everywhere, by farthest-point sampling.
    Uniform,
    /// Drawn with the tets' volumes as probabilities, seeded.
    Random,
}

/// What a cubature point's weight starts from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Weights {
    /// The volume of the tets nearest to it.
    #[default]
    Cells,
    /// The integral of its biharmonic coordinate (equations 5 to 7), its cell where that is negative; all cells where
    /// more than 3 % are.
    Biharmonic,
}

impl Cubature {
    /// Every tet with its own tissue volume.
    pub fn all_tets(tissue: Tissue<'_>) -> Self {
        let weights = tissue.tet_volumes();
        let report = CubatureReport {
            points: weights.len(),
            volume: tissue.moments().0,
            weight_sum: weights.iter().sum(),
            all_tets: true,
            ..Default::default()
        };
        Self {
            tets: (0..weights.len() as u32).collect(),
            weights,
            report,
        }
    }

    /// `count` points by `method`, or every tet where there are too few of them. `basis` is the handles of each node,
    /// `stiffness` the factor s on the material's in each tet.
    ///
    /// The paper's points are uniform, and its weights know nothing of the handles. With the default method points are
    /// as dense as the handles' stiffness, and their weights give each handle its ∫ s |∇U|². Where the paper's add 10 to
    /// 50 % to the error of a press, these add −7 to 12 % (bone press on mesh S, 20 to 160 handles, ten points a handle).
    /// The density does not know s: where soft and stiff tissue lie one behind the other it is the soft one that
    /// deforms, and a stiff part should not draw points away from it.
    ///
    /// # Errors
    /// [`Error::Invalid`] where `count` is below 5: four points only just carry the first moments.
    pub fn sampled(
        tissue: Tissue<'_>,
        method: CubatureMethod,
        count: usize,
        basis: &Rows<(u32, f64)>,
        stiffness: &[f64],
    ) -> Result<Self> {
        if count < 5 {
            return Err(Error::invalid(
                "recipe.cubature.points",
                "at least 5 are needed",
            ));
        }
        let candidates = candidates(tissue, TETS_PER_POINT * count);
        if TETS_PER_POINT * count >= candidates.len() {
            return Ok(Self::all_tets(tissue));
        }
        let slopes = squared_slopes(tissue.mesh, basis);
        let tets = sample(tissue, method.sampling, &slopes, &candidates, count);
        let Prior {
            weights: prior,
            negative,
            cells,
        } = Prior::of(tissue, method.weights, &tets);
        let scaled = slopes.iter().zip(stiffness);
        let scaled = scaled.map(|(row, s)| row.iter().map(move |&(h, slope)| (h, s * slope)));
        let moments = Moments::of(tissue, &tets, &scaled.collect());
        let wanted = if method.keep_stiffness {
            &moments
        } else {
            &moments.exact_only()
        };
        let Some(weights) = nearest_weights(&prior, wanted) else {
            return Ok(Self::all_tets(tissue));
        };
        let report = CubatureReport {
            points: tets.len(),
            volume: tissue.moments().0,
            weight_sum: weights.iter().sum(),
            negative_weights: negative,
            cells,
            stiffness_error: [&prior, &weights].map(|w| moments.stiffness_error(w)),
            all_tets: false,
        };
        Ok(Self {
            tets,
            weights,
            report,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_mesh::partly_tissue;
    use glam::DVec3;

    /// Ten bumps, each over a part of the nodes.
    fn basis(mesh: &TetMesh) -> Rows<(u32, f64)> {
        let centre = |h: u32| mesh.nodes[h as usize * mesh.nodes.len() / 10];
        let bump = |x: DVec3, h| (1.0 - (x.distance(centre(h)) / 0.03).powi(2)).max(0.0);
        let row = |x: &DVec3| {
            { (0..10u32).map(|h| (h, bump(*x, h))) }
                .filter(|e| e.1 > 0.0)
                .collect::<Vec<_>>()
        };
        mesh.nodes.iter().map(row).collect()
    }

    #[test]
    fn volume_and_first_moment_are_exact_and_weights_positive() {
        let (mesh, fraction) = partly_tissue();
        let tissue = Tissue {
            mesh: &mesh,
            fraction: &fraction,
        };
        let (volume, first) = tissue.moments();
        let even = vec![1.0; mesh.tets.len()];
        for sampling in [Sampling::Stiffness, Sampling::Uniform, Sampling::Random] {
            for weights in [Weights::Cells, Weights::Biharmonic] {
                let method = CubatureMethod {
                    sampling,
                    weights,
                    keep_stiffness: true,
                };
                let cubature = Cubature::sampled(tissue, method, 60, &basis(&mesh), &even).unwrap();
                let report = &cubature.report;
                assert!(!report.all_tets, "{method:?}: {report:?}");
                let [before, after] = report.stiffness_error;
                assert!(
                    before > 0.05 && after < 0.2 * before,
                    "{method:?}: {report:?}"
                );
                assert!(cubature.weights.iter().all(|w| *w > 0.0));
                assert!((cubature.weights.iter().sum::<f64>() / volume - 1.0).abs() < 1e-12);
                let points = cubature.tets.iter().zip(&cubature.weights);
                let sum: DVec3 = points.map(|(&t, w)| *w * mesh.centroid(t as usize)).sum();
                let error = (sum - first).length();
                assert!(error < 1e-12 * volume * 0.1, "{method:?}: {error:e}");
            }
        }
        assert!((tissue.nodal_volumes().iter().sum::<f64>() / volume - 1.0).abs() < 1e-13);
    }

    #[test]
    fn samples_as_dense_as_the_mesh_use_every_tet() {
        let (mesh, fraction) = partly_tissue();
        let tissue = Tissue {
            mesh: &mesh,
            fraction: &fraction,
        };
        let cubature = Cubature::sampled(
            tissue,
            CubatureMethod::default(),
            mesh.tets.len() / 4,
            &basis(&mesh),
            &vec![1.0; mesh.tets.len()],
        )
        .unwrap();
        assert!(cubature.report.all_tets && cubature.weights == tissue.tet_volumes());
        assert!(
            Cubature::sampled(tissue, CubatureMethod::default(), 4, &basis(&mesh), &[]).is_err()
        );
    }
}
