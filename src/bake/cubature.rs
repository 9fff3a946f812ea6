//! Data-oblivious cubature: points spread over the tissue, weights from their own biharmonic
//! coordinates (Tapia et al. 2021, equations 5 to 7).

use super::biharmonic::{BiharmonicSystem, Constraints};
use super::biharmonic_energy::BasisEnergy;
use super::cubature_weights::{Moments, nearest_weights};
use super::points::basis_at_tets;
use super::sampling::{Density, weighted_farthest_points};
use crate::math::{Rows, par_map};
use crate::model::TetMesh;
use crate::{Error, Result};
use glam::DVec3;
use serde::{Deserialize, Serialize};

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
    pub(super) fn moments(&self) -> (f64, DVec3) {
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
    /// Whether every point took its cell's volume, more than 3 % being negative.
    pub cells: bool,
    /// Root mean square over the handles of the relative error of ∫ |∇U|², before the weights were
    /// corrected for it and after.
    pub stiffness_error: [f64; 2],
    /// Whether every tet became a point.
    pub all_tets: bool,
}

/// With a larger share of negative weights the positive ones are no use either.
const MOST_NEGATIVE: f64 = 0.03;
/// Fewer tets than this a point, and every tet is a point.
const TETS_PER_POINT: usize = 4;
/// Density of points where no handle reaches, relative to what the mean of Σ |∇U|² has. At 0.1 a soft palm between thin
/// fingers was left to a few points, and a tet inverted.
const FLOOR: f64 = 0.5;

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

    /// `count` points, closest together where handles are, or every tet where there are too few of them.
    /// `basis` is the handles of each node.
    ///
    /// The paper's points are uniform, and its weights know nothing of the handles. Here points are as dense as the
    /// handles' stiffness, and their weights are corrected, as little as possible, so that they also give each
    /// handle its ∫ |∇U|². Where uniform points add 10 to 50 % to the error of a press, these add −9 to 17 % (bone
    /// press on mesh S, 20 to 160 handles, ten points a handle).
    ///
    /// # Errors
    /// [`Error::Invalid`] where `count` is below 5: four points only just carry the first moments.
    pub fn sampled(tissue: Tissue<'_>, count: usize, basis: &Rows<(u32, f64)>) -> Result<Self> {
        if count < 5 {
            return Err(Error::invalid("cubature.points", "at least 5 are needed"));
        }
        let candidates = candidates(tissue, count);
        if TETS_PER_POINT * count >= candidates.len() {
            return Ok(Self::all_tets(tissue));
        }
        let slopes = squared_slopes(tissue.mesh, basis);
        let tets = spread(tissue, &slopes, &candidates, count);
        // Points too dense for the mesh give a singular system.
        let raw = raw_weights(tissue, &tets).unwrap_or_default();
        let (prior, negative_weights, cells) = positive_weights(tissue, &tets, raw);
        let moments = Moments::of(tissue, &tets, &slopes);
        let Some(weights) = nearest_weights(&prior, &moments) else {
            return Ok(Self::all_tets(tissue));
        };
        let report = CubatureReport {
            points: tets.len(),
            volume: tissue.moments().0,
            weight_sum: weights.iter().sum(),
            negative_weights,
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

/// `count` tets among `candidates` by farthest-point sampling, as dense as the handles' stiffness: where
/// distances count s^(1/3) times, points are s times as dense. s = Σ_h |∇U_h|² over its mean, plus [`FLOOR`]
/// for the mass where nothing moves.
fn spread(
    tissue: Tissue<'_>,
    slopes: &Rows<(u32, f64)>,
    candidates: &[u32],
    count: usize,
) -> Vec<u32> {
    let steepness = |&t: &u32| slopes.row(t as usize).iter().map(|s| s.1).sum::<f64>();
    let volume = |&t: &u32| tissue.mesh.volume(t as usize);
    let mean = candidates
        .iter()
        .map(|t| volume(t) * steepness(t))
        .sum::<f64>()
        / candidates.iter().map(volume).sum::<f64>();
    let weights: Vec<f64> = (candidates.iter())
        .map(|t| {
            if mean > 0.0 {
                (steepness(t) / mean + FLOOR).cbrt()
            } else {
                1.0
            }
        })
        .collect();
    let centroids: Vec<DVec3> = (candidates.iter())
        .map(|&t| tissue.mesh.centroid(t as usize))
        .collect();
    weighted_farthest_points(&centroids, &weights, &[], Density::Count(count))
        .into_iter()
        .map(|i| candidates[i as usize])
        .collect()
}

/// (handle, |∇U_h|²) of each tet, 1/m², handles rising; `basis` is the handles of each node.
fn squared_slopes(mesh: &TetMesh, basis: &Rows<(u32, f64)>) -> Rows<(u32, f64)> {
    let all: Vec<u32> = (0..mesh.tets.len() as u32).collect();
    basis_at_tets(mesh, basis, &all).map(|u| (u.handle, u.gradient.length_squared()))
}

/// Tets that may carry a point: those mostly tissue, if they are many, so that points lie inside it.
fn candidates(tissue: Tissue<'_>, count: usize) -> Vec<u32> {
    let all = 0..tissue.fraction.len() as u32;
    let inside: Vec<u32> = (all.clone())
        .filter(|&t| tissue.fraction[t as usize] >= 0.5)
        .collect();
    if inside.len() > TETS_PER_POINT * count {
        inside
    } else {
        all.collect()
    }
}

/// w_i = ∫ α_i, α_i the biharmonic coordinate of centroid i: \[A Cᵀ; C 0\]\[x; w\] = \[m; 0\], rows of C
/// being ¼ at a tet's nodes and m the nodal volumes.
fn raw_weights(tissue: Tissue<'_>, tets: &[u32]) -> Result<Vec<f64>> {
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

/// The biharmonic weights `raw` with a cell's volume in place of each negative one, or the cells' volumes alone where
/// those are too many or there are no weights at all; how many were negative, and whether it is the cells.
fn positive_weights(tissue: Tissue<'_>, tets: &[u32], raw: Vec<f64>) -> (Vec<f64>, usize, bool) {
    let negative = raw.iter().filter(|w| **w <= 0.0).count();
    if negative == 0 && !raw.is_empty() {
        return (raw, 0, false);
    }
    let cells = cell_volumes(tissue, tets);
    if raw.is_empty() || negative as f64 > MOST_NEGATIVE * raw.len() as f64 {
        return (cells, negative, true);
    }
    let positive = |(w, cell): (f64, f64)| if w > 0.0 { w } else { cell };
    (
        raw.into_iter().zip(cells).map(positive).collect(),
        negative,
        false,
    )
}

/// Tissue volume of the tets nearer to each point than to any other.
fn cell_volumes(tissue: Tissue<'_>, tets: &[u32]) -> Vec<f64> {
    let centroid = |&t: &u32| tissue.mesh.centroid(t as usize);
    let points: Vec<DVec3> = tets.iter().map(centroid).collect();
    let nearest = par_map(tissue.mesh.tets.len(), |t| {
        let place = tissue.mesh.centroid(t);
        let squares = points.iter().map(|p| p.distance_squared(place)).enumerate();
        let best = squares.min_by(|a, b| a.1.total_cmp(&b.1));
        best.map_or(0, |(i, _)| i)
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
    use crate::bake::test_mesh::jittered_box;
    use crate::math::Random;

    /// A box in which some tets are partly tissue.
    fn sample() -> (TetMesh, Vec<f64>) {
        let mesh = jittered_box([8, 7, 6], 0.01, 0.15, 21);
        let mut random = Random::new(22);
        let fraction = (mesh.tets.iter())
            .map(|_| {
                if random.uniform(0.0, 1.0) < 0.3 {
                    0.2 + 0.8 * random.uniform(0.0, 1.0)
                } else {
                    1.0
                }
            })
            .collect();
        (mesh, fraction)
    }

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
        let (mesh, fraction) = sample();
        let tissue = Tissue {
            mesh: &mesh,
            fraction: &fraction,
        };
        let (volume, first) = tissue.moments();
        let cubature = Cubature::sampled(tissue, 60, &basis(&mesh)).unwrap();
        assert!(!cubature.report.all_tets, "{:?}", cubature.report);
        let [before, after] = cubature.report.stiffness_error;
        assert!(before > 0.05 && after < 0.2 * before, "{before} to {after}");
        assert!(cubature.weights.iter().all(|w| *w > 0.0));
        assert!((cubature.weights.iter().sum::<f64>() / volume - 1.0).abs() < 1e-12);
        let points = cubature.tets.iter().zip(&cubature.weights);
        let sum: DVec3 = points.map(|(&t, w)| *w * mesh.centroid(t as usize)).sum();
        assert!(
            (sum - first).length() < 1e-12 * volume * 0.1,
            "{}",
            sum - first
        );
        assert!((tissue.nodal_volumes().iter().sum::<f64>() / volume - 1.0).abs() < 1e-13);
    }

    #[test]
    fn the_solve_alone_already_has_the_moments() {
        let (mesh, fraction) = sample();
        let tissue = Tissue {
            mesh: &mesh,
            fraction: &fraction,
        };
        let (volume, first) = tissue.moments();
        let tets: Vec<u32> = (0..40).map(|i| i * 49 + 3).collect();
        let weights = raw_weights(tissue, &tets).unwrap();
        assert!((weights.iter().sum::<f64>() / volume - 1.0).abs() < 1e-12);
        let points = tets.iter().zip(&weights);
        let sum: DVec3 = points.map(|(&t, w)| *w * mesh.centroid(t as usize)).sum();
        assert!(
            (sum - first).length() < 1e-12 * volume * 0.1,
            "{}",
            sum - first
        );
    }

    #[test]
    fn negative_weights_become_cells_and_many_of_them_all_cells() {
        let (mesh, fraction) = sample();
        let tissue = Tissue {
            mesh: &mesh,
            fraction: &fraction,
        };
        let volume = tissue.moments().0;
        let tets: Vec<u32> = (0..100).map(|i| i * 20).collect();
        let cells = cell_volumes(tissue, &tets);
        assert!((cells.iter().sum::<f64>() / volume - 1.0).abs() < 1e-12);
        let mut raw = vec![volume / 97.0; 100];
        raw[10..13].fill(-volume / 97.0);
        let (weights, negative, all_cells) = positive_weights(tissue, &tets, raw.clone());
        assert_eq!((negative, all_cells), (3, false));
        assert_eq!((weights[9], weights[10]), (raw[9], cells[10]));
        raw[13] = -volume / 97.0;
        let (weights, negative, all_cells) = positive_weights(tissue, &tets, raw);
        assert_eq!((weights, negative, all_cells), (cells.clone(), 4, true));
        let none = positive_weights(tissue, &tets, Vec::new());
        assert_eq!(none, (cells, 0, true));
    }

    #[test]
    fn samples_as_dense_as_the_mesh_use_every_tet() {
        let (mesh, fraction) = sample();
        let tissue = Tissue {
            mesh: &mesh,
            fraction: &fraction,
        };
        let cubature = Cubature::sampled(tissue, mesh.tets.len() / 4, &basis(&mesh)).unwrap();
        assert!(cubature.report.all_tets && cubature.weights == tissue.tet_volumes());
        assert!(Cubature::sampled(tissue, 4, &basis(&mesh)).is_err());
    }
}
