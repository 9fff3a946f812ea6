//! Morph targets that play the unposed displacement of the skin.

use super::Recording;
use faer::{Mat, Side};
use glam::DVec3;
use supple::internal::cpu::skin_displacement;
use supple::internal::features::pose_feature;
use supple::model::{Avatar, State};
use supple::{Error, Result};

/// Most morph targets where nothing else is asked: so many every viewer takes.
pub const MOST_MORPHS: usize = 64;

/// Largest displacement that a low-rank set of morphs may miss, m.
pub const MORPH_TOLERANCE: f64 = 1e-5;

/// Unposed displacement = Σ weight · target.
pub(super) struct Morphs {
    pub names: Vec<String>,
    /// `targets[k][v]`, m.
    pub targets: Vec<Vec<DVec3>>,
    /// `weights[s][k]` at each recorded state.
    pub weights: Vec<Vec<f64>>,
    /// Largest displacement missed at any vertex and state, m.
    pub largest_error: f64,
    /// Whether a target is a handle's axis.
    pub per_handle: bool,
}

impl Morphs {
    /// At most `most` targets: one for each handle and axis where that plays everything, else a low-rank basis of what
    /// was recorded.
    pub fn new(avatar: &Avatar, recording: &Recording, most: usize) -> Result<Self> {
        // A slot for fine handles stands for one after the other.
        let plain = avatar.skin.pose_blend.features == 0 && avatar.fine.slots == 0;
        if plain && 3 * avatar.handles.len() <= most {
            Ok(per_handle(avatar, recording))
        } else {
            low_rank(avatar, recording, most)
        }
    }
}

/// B_P(θ) + Σ U φ at every skin vertex, m.
fn displacement(avatar: &Avatar, state: &State) -> Vec<DVec3> {
    let skin = &avatar.skin;
    let mut out = skin_displacement(avatar, state);
    if skin.pose_blend.features > 0 {
        let feature = pose_feature(&avatar.skeleton.parents, &state.frames);
        let columns = skin.pose_blend.columns.chunks_exact(skin.len().max(1));
        for (value, column) in feature.iter().zip(columns) {
            for (d, c) in out.iter_mut().zip(column) {
                *d += *value * DVec3::from_array(c.map(f64::from));
            }
        }
    }
    out
}

/// Target (h, axis) is U_h · 10 mm along the axis; its weight is φ in units of 10 mm.
fn per_handle(avatar: &Avatar, recording: &Recording) -> Morphs {
    const UNIT: f64 = 0.01;
    let handles = avatar.handles.len();
    let mut targets = vec![vec![DVec3::ZERO; avatar.skin.len()]; 3 * handles];
    for (v, row) in avatar.skin.basis.iter().enumerate() {
        for u in row {
            for axis in 0..3 {
                targets[3 * u.handle as usize + axis][v][axis] += UNIT * u.value;
            }
        }
    }
    let weights = |s: &State| {
        s.handles
            .iter()
            .flat_map(|h| (*h / UNIT).to_array())
            .collect()
    };
    Morphs {
        names: (0..handles)
            .flat_map(|h| ["x", "y", "z"].map(|axis| format!("handle_{h}_{axis}")))
            .collect(),
        targets,
        weights: recording.states.iter().map(weights).collect(),
        largest_error: 0.0,
        per_handle: true,
    }
}

/// Proper orthogonal decomposition by the method of snapshots (Sirovich 1987): with D the displacements
/// (a column a state), Dᵀ D = V Λ Vᵀ, the targets D V span the best subspace of each rank.
///
/// Targets are taken until no vertex misses more than [`MORPH_TOLERANCE`] at any state, or there are
/// `most` of them; what is missed then is in the report.
fn low_rank(avatar: &Avatar, recording: &Recording, most: usize) -> Result<Morphs> {
    let states = &recording.states;
    let rows = 3 * avatar.skin.len();
    let mut residual: Mat<f64> = Mat::zeros(rows, states.len());
    for (s, state) in states.iter().enumerate() {
        for (v, d) in displacement(avatar, state).iter().enumerate() {
            for axis in 0..3 {
                residual[(3 * v + axis, s)] = d[axis];
            }
        }
    }
    let gram = residual.transpose() * &residual;
    let eigen = gram
        .self_adjoint_eigen(Side::Lower)
        .map_err(|e| Error::Solve {
            system: "morph targets",
            problem: format!("{e:?}"),
        })?;
    let mut morphs = Morphs {
        names: Vec::new(),
        targets: Vec::new(),
        weights: vec![Vec::new(); states.len()],
        largest_error: largest_vector(&residual),
        per_handle: false,
    };
    // Eigenvalues rise: the last one is the mode that carries most.
    for k in (0..states.len()).rev().take(most) {
        if morphs.largest_error <= MORPH_TOLERANCE {
            break;
        }
        let v = eigen.U().col(k);
        // The target is scaled so that its largest weight is 1.
        let scale = (0..states.len()).map(|s| v[s].abs()).fold(0.0, f64::max);
        let target = &residual * v;
        let target: Vec<f64> = (0..rows).map(|i| target[i] * scale).collect();
        for s in 0..states.len() {
            let weight = v[s] / scale;
            morphs.weights[s].push(weight);
            let column = residual.col_mut(s).try_as_col_major_mut();
            let column = column.map(|c| c.as_slice_mut()).unwrap_or_default();
            for (r, t) in column.iter_mut().zip(&target) {
                *r -= weight * t;
            }
        }
        let vectors = target.chunks_exact(3).map(DVec3::from_slice);
        morphs.targets.push(vectors.collect());
        morphs.names.push(format!("mode_{}", morphs.targets.len()));
        morphs.largest_error = largest_vector(&residual);
    }
    Ok(morphs)
}

/// Length of the longest vector in a matrix of stacked vectors.
fn largest_vector(m: &Mat<f64>) -> f64 {
    (0..m.ncols())
        .flat_map(|s| (0..m.nrows() / 3).map(move |v| (v, s)))
        .map(|(v, s)| DVec3::new(m[(3 * v, s)], m[(3 * v + 1, s)], m[(3 * v + 2, s)]).length())
        .fold(0.0, f64::max)
}
