//! Which tets carry a cubature point.

use super::cubature::{Sampling, Tissue};
use crate::basis::basis_at_tets;
use crate::handles::{Density, weighted_farthest_points};
use glam::DVec3;
use supple::internal::math::{Random, Rows};
use supple::model::TetMesh;

/// Density of points where no handle reaches, relative to what the mean of Σ |∇U|² has. At 0.1 a soft palm between thin
/// fingers was left to a few points, and a tet inverted.
const FLOOR: f64 = 0.5;
/// Seed of random sampling.
const SEED: u64 = 1;

/// `count` of the `candidates`; `slopes` is (handle, |∇U_h|²) of each tet of the mesh.
pub(crate) fn sample(
    tissue: Tissue<'_>,
    sampling: Sampling,
    slopes: &Rows<(u32, f64)>,
    candidates: &[u32],
    count: usize,
) -> Vec<u32> {
    let weights = match sampling {
        Sampling::Stiffness => stiffness(tissue, slopes, candidates),
        Sampling::Uniform => vec![1.0; candidates.len()],
        Sampling::Random => return random(tissue, candidates, count),
    };
    let centroids: Vec<DVec3> = (candidates.iter())
        .map(|&t| tissue.mesh.centroid(t as usize))
        .collect();
    weighted_farthest_points(&centroids, &weights, &[], Density::Count(count))
        .into_iter()
        .map(|i| candidates[i as usize])
        .collect()
}

/// Distances count s^(1/3) times, so that points are s times as dense: s = Σ_h |∇U_h|² over its mean, plus [`FLOOR`]
/// for the mass where nothing moves. Smoothed, since the farthest candidate would else be the steepest of
/// its neighbourhood and stand for flatter ones.
fn stiffness(tissue: Tissue<'_>, slopes: &Rows<(u32, f64)>, candidates: &[u32]) -> Vec<f64> {
    let mesh = tissue.mesh;
    let volumes: Vec<f64> = (0..mesh.tets.len()).map(|t| mesh.volume(t)).collect();
    let sum_of = |row: &[(u32, f64)]| row.iter().map(|s| s.1).sum::<f64>();
    let steepness: Vec<f64> = slopes.iter().map(sum_of).collect();
    let steepness = smoothed(mesh, &volumes, &steepness);
    let whole: f64 = volumes.iter().sum();
    let sum: f64 = volumes.iter().zip(&steepness).map(|(v, s)| v * s).sum();
    if sum == 0.0 {
        return vec![1.0; candidates.len()];
    }
    let density = |&t: &u32| steepness[t as usize] * whole / sum + FLOOR;
    candidates.iter().map(|t| density(t).cbrt()).collect()
}

/// Each tet's mean over its nodes of the mean over the tets around a node.
fn smoothed(mesh: &TetMesh, volumes: &[f64], values: &[f64]) -> Vec<f64> {
    let mut nodes = vec![(0.0, 0.0); mesh.nodes.len()];
    for ((tet, volume), value) in mesh.tets.iter().zip(volumes).zip(values) {
        for &n in tet {
            nodes[n as usize].0 += volume * value;
            nodes[n as usize].1 += volume;
        }
    }
    let at = |n: &u32| nodes[*n as usize].0 / nodes[*n as usize].1;
    let mean = |tet: &[u32; 4]| tet.iter().map(at).sum::<f64>() / 4.0;
    mesh.tets.iter().map(mean).collect()
}

/// Tets drawn without repetition, volumes being probabilities: each takes part with the key u^(1/volume), and the largest
/// keys win (Efraimidis and Spirakis 2006).
fn random(tissue: Tissue<'_>, candidates: &[u32], count: usize) -> Vec<u32> {
    let mut random = Random::new(SEED);
    let mut key = |t: u32| random.uniform(0.0, 1.0).ln() / tissue.mesh.volume(t as usize);
    let mut keys: Vec<(f64, u32)> = candidates.iter().map(|&t| (key(t), t)).collect();
    keys.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    keys.into_iter().take(count).map(|k| k.1).collect()
}

/// (handle, |∇U_h|²) of each tet, 1/m², handles rising; `basis` is the handles of each node.
pub(crate) fn squared_slopes(mesh: &TetMesh, basis: &Rows<(u32, f64)>) -> Rows<(u32, f64)> {
    let all: Vec<u32> = (0..mesh.tets.len() as u32).collect();
    basis_at_tets(mesh, basis, &all).map(|u| (u.handle, u.gradient.length_squared()))
}

/// Tets that may carry a point: those mostly tissue, if there are more than `enough`, so that points lie inside it.
pub(crate) fn candidates(tissue: Tissue<'_>, enough: usize) -> Vec<u32> {
    let all = 0..tissue.fraction.len() as u32;
    let inside: Vec<u32> = (all.clone())
        .filter(|&t| tissue.fraction[t as usize] >= 0.5)
        .collect();
    if inside.len() > enough {
        inside
    } else {
        all.collect()
    }
}
