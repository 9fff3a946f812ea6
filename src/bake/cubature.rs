//! Data-oblivious cubature: points spread over the tissue, weights from their own biharmonic
//! coordinates (Tapia et al. 2021, equations 5 to 7).

use super::biharmonic::{BiharmonicSystem, Constraints};
use super::sampling::{Density, farthest_points};
use crate::model::TetMesh;
use crate::{Error, Result};
use glam::{DMat4, DVec3, DVec4};
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
    fn moments(&self) -> (f64, DVec3) {
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
    /// Negative weights of the sample that was kept; their points were dropped and the rest scaled
    /// by 1 + a + b · X so that volume and first moment stay exact.
    pub negative_weights: usize,
    /// Samples drawn before one had at most 3 % negative weights.
    pub samples: usize,
    /// Whether every tet became a point.
    pub all_tets: bool,
}

/// A sample with a larger share of negative weights is drawn again, with fewer points.
const MOST_NEGATIVE: f64 = 0.03;
/// Each new sample has this share of the points before: dense samples are what makes weights negative.
const THINNING: f64 = 0.8;
/// Samples before every tet is used.
const MOST_SAMPLES: usize = 4;

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

    /// About `count` points, nine in ten of them in the tets that `moving` handles reach: elsewhere a
    /// point carries mass and nothing else. Every tet where the sample would take half of them or more,
    /// or where samples keep having more than 3 % negative weights.
    ///
    /// # Errors
    /// [`Error::Invalid`] where `count` is below 5: four points only just carry the first moments.
    pub fn sampled(tissue: Tissue<'_>, count: usize, moving: &[bool]) -> Result<Self> {
        if count < 5 {
            return Err(Error::invalid("cubature.points", "at least 5 are needed"));
        }
        let (moving, still): (Vec<u32>, Vec<u32>) =
            (candidates(tissue, count).into_iter()).partition(|&t| moving[t as usize]);
        let mut count = count;
        // Points of negative weight are dropped; a second sample of so many more makes up for them.
        let mut short: Option<Self> = None;
        for sample in 1..=MOST_SAMPLES {
            if 2 * count >= tissue.mesh.tets.len() || count < 5 {
                break;
            }
            let spare = short.as_ref().map_or(0, |c| count - c.tets.len());
            let tets = spread(tissue.mesh, &moving, &still, count + spare);
            // Points too dense for the mesh give a singular system: thin out as well.
            let kept = raw_weights(tissue, &tets)
                .ok()
                .and_then(|weights| keep_positive(tissue, &tets, &weights, sample));
            match (kept, short.take()) {
                (Some(cubature), None) if cubature.tets.len() < count => short = Some(cubature),
                (Some(cubature), _) | (None, Some(cubature)) => return Ok(cubature),
                (None, None) => count = (count as f64 * THINNING) as usize,
            }
        }
        if let Some(cubature) = short {
            return Ok(cubature);
        }
        let mut whole = Self::all_tets(tissue);
        whole.report.samples = MOST_SAMPLES;
        Ok(whole)
    }
}

/// `count` tets spread evenly, nine in ten of them among `moving` where there are others.
fn spread(mesh: &TetMesh, moving: &[u32], still: &[u32], count: usize) -> Vec<u32> {
    let outside = if moving.is_empty() { count } else { count / 10 };
    let inside = count - outside.min(still.len());
    let mut tets = Vec::with_capacity(count);
    let mut places = Vec::with_capacity(count);
    for (part, count) in [(moving, inside), (still, outside)] {
        let centroids: Vec<DVec3> = part.iter().map(|&t| mesh.centroid(t as usize)).collect();
        for i in farthest_points(&centroids, &places, Density::Count(count)) {
            tets.push(part[i as usize]);
        }
        places.extend(tets.iter().map(|&t| mesh.centroid(t as usize)));
    }
    tets
}

/// Tets that may carry a point: those mostly tissue, if they are many, so that points lie inside it.
fn candidates(tissue: Tissue<'_>, count: usize) -> Vec<u32> {
    let all = 0..tissue.fraction.len() as u32;
    let inside: Vec<u32> = (all.clone())
        .filter(|&t| tissue.fraction[t as usize] >= 0.5)
        .collect();
    if inside.len() >= 4 * count {
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
    let weights =
        BiharmonicSystem::new(tissue.mesh, &none, &centroids)?.integrals(&tissue.nodal_volumes());
    if weights.iter().all(|w| w.is_finite()) {
        Ok(weights)
    } else {
        Err(Error::NotFinite {
            quantity: "cubature weights",
        })
    }
}

/// Drops points of negative weight; `None` where they are too many or the rest cannot take over.
fn keep_positive(
    tissue: Tissue<'_>,
    tets: &[u32],
    weights: &[f64],
    sample: usize,
) -> Option<Cubature> {
    let negative_weights = weights.iter().filter(|w| **w <= 0.0).count();
    if negative_weights as f64 > MOST_NEGATIVE * weights.len() as f64 {
        return None;
    }
    let (tets, mut weights): (Vec<u32>, Vec<f64>) = (tets.iter().zip(weights))
        .filter(|(_, w)| **w > 0.0)
        .unzip();
    restore_moments(tissue, &tets, &mut weights)?;
    let report = CubatureReport {
        points: tets.len(),
        volume: tissue.moments().0,
        weight_sum: weights.iter().sum(),
        negative_weights,
        samples: sample,
        all_tets: false,
    };
    Some(Cubature {
        tets,
        weights,
        report,
    })
}

/// w_i ← w_i (1 + a + b · X_i) with the a and b that give the tissue's volume and first moment.
/// `None` where that would turn a weight negative.
fn restore_moments(tissue: Tissue<'_>, tets: &[u32], weights: &mut [f64]) -> Option<()> {
    let (volume, first) = tissue.moments();
    let mean = first / volume;
    let scale = volume.cbrt();
    let affine: Vec<DVec4> = (tets.iter())
        .map(|&t| ((tissue.mesh.centroid(t as usize) - mean) / scale).extend(1.0))
        .collect();
    // Twice: the second pass removes what rounding left of the first.
    for _ in 0..2 {
        let mut moments = DMat4::ZERO;
        let mut missing = DVec4::new(0.0, 0.0, 0.0, volume);
        for (w, y) in weights.iter().zip(&affine) {
            moments += *w * DMat4::from_cols(*y * y.x, *y * y.y, *y * y.z, *y * y.w);
            missing -= *w * *y;
        }
        let factors = moments.inverse() * missing;
        for (w, y) in weights.iter_mut().zip(&affine) {
            *w *= 1.0 + factors.dot(*y);
        }
    }
    weights
        .iter()
        .all(|w| w.is_finite() && *w > 0.0)
        .then_some(())
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

    #[test]
    fn volume_and_first_moment_are_exact_and_weights_positive() {
        let (mesh, fraction) = sample();
        let tissue = Tissue {
            mesh: &mesh,
            fraction: &fraction,
        };
        let (volume, first) = tissue.moments();
        let cubature = Cubature::sampled(tissue, 60, &vec![true; mesh.tets.len()]).unwrap();
        assert!(!cubature.report.all_tets, "{:?}", cubature.report);
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
    fn negative_weights_are_dropped_within_three_percent_only() {
        let (mesh, fraction) = sample();
        let tissue = Tissue {
            mesh: &mesh,
            fraction: &fraction,
        };
        let volume = tissue.moments().0;
        let tets: Vec<u32> = (0..100).map(|i| i * 20).collect();
        let mut weights = vec![volume / 96.0; 100];
        weights[10] = -volume / 96.0;
        weights[50] = -volume / 96.0;
        let kept = keep_positive(tissue, &tets, &weights, 1).unwrap();
        assert_eq!((kept.report.negative_weights, kept.tets.len()), (2, 98));
        assert!((kept.report.weight_sum / volume - 1.0).abs() < 1e-12);
        weights[20] = -volume / 96.0;
        weights[21] = -volume / 96.0;
        assert!(keep_positive(tissue, &tets, &weights, 1).is_none());
    }

    #[test]
    fn samples_as_dense_as_the_mesh_use_every_tet() {
        let (mesh, fraction) = sample();
        let tissue = Tissue {
            mesh: &mesh,
            fraction: &fraction,
        };
        let all = vec![true; mesh.tets.len()];
        let cubature = Cubature::sampled(tissue, mesh.tets.len() / 2, &all).unwrap();
        assert!(cubature.report.all_tets && cubature.weights == tissue.tet_volumes());
        assert!(Cubature::sampled(tissue, 4, &all).is_err());
    }
}
