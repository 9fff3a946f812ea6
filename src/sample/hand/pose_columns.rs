//! Pose blend shapes that give back what linear blending loses at bent joints.
//!
//! Linear blending shortens the way across a bent joint and folds volume away (the "candy wrapper" and
//! the "collapsing elbow"); blending dual quaternions keeps sections rigid (Kavan et al. 2007). For
//! seeded random poses the difference between the two, taken back to unposed space,
//!
//!   Δ_v(θ) = B_v⁻¹ ( x_dual(v, θ) − x_linear(v, θ) ),   B_v = Σ_j w_vj R_j,
//!
//! is fitted by ridge regression with SMPL's feature f(θ) (rows of R_parentᵀ R_child − I). A vertex uses
//! only the features of joints between its own bones, so every column is local and vanishes at rest.

use super::anatomy::Digit;
use super::poses::{dual_quaternion_skin, random_pose};
use crate::Result;
use crate::math::{DenseFactor, Random, par_map};
use crate::model::{Frame, ParametricModel, Skeleton, SkinWeight, pose_feature};
use glam::{DMat3, DVec3};
use std::collections::BTreeMap;

/// Poses fitted, and their seed.
const POSES: usize = 320;
const SEED: u64 = 0x5eed_0001;
/// Ridge, relative to the mean square of a feature: nine numbers describe a joint that mostly turns
/// about one axis, so the fit is ill-posed without it.
const RIDGE: f64 = 2e-3;
/// How much of the difference is fitted: dual quaternions bulge a little, so less than all of it keeps
/// the volume best.
const SHARE: f64 = 1.0;

/// Whether bone `a` is `b` or above it.
fn is_above(parents: &[Option<u32>], a: u32, mut b: u32) -> bool {
    loop {
        if a == b {
            return true;
        }
        match parents[b as usize] {
            Some(p) => b = p,
            None => return false,
        }
    }
}

/// Joints (non-root bones) that move some of the vertex's bones against others.
fn active_joints(parents: &[Option<u32>], row: &[SkinWeight]) -> Vec<usize> {
    (1..parents.len())
        .filter(|&j| {
            let moved = |w: &&SkinWeight| is_above(parents, j as u32, w.bone);
            let count = row.iter().filter(moved).count();
            count > 0 && count < row.len()
        })
        .collect()
}

/// Δ of every vertex in one pose.
fn corrections(model: &ParametricModel, skeleton: &Skeleton, frames: &[Frame]) -> Vec<DVec3> {
    let correct = |(&x, row): (&DVec3, &[SkinWeight])| {
        if row.len() < 2 {
            return DVec3::ZERO;
        }
        let bones = || {
            row.iter().map(|w| {
                let j = w.bone as usize;
                (
                    w.weight,
                    frames[j].rotation,
                    frames[j].position,
                    skeleton.joints[j],
                )
            })
        };
        let linear: DVec3 = bones()
            .map(|(w, r, c, joint)| w * (r * (x - joint) + c))
            .sum();
        let blend = bones().fold(DMat3::ZERO, |b, (w, r, ..)| b + r * w);
        let difference = dual_quaternion_skin(x, bones()) - linear;
        // Bends stay well below 180°, so B is invertible.
        SHARE * (blend.inverse() * difference)
    };
    model
        .template
        .iter()
        .zip(model.weights.iter())
        .map(correct)
        .collect()
}

/// The fitted columns: `[feature][vertex]`.
pub(super) fn pose_columns(
    model: &ParametricModel,
    digits: &[Digit; 5],
) -> Result<Vec<Vec<DVec3>>> {
    let skeleton = model.skeleton(&[]);
    let features = 9 * (skeleton.len() - 1);
    let mut random = Random::new(SEED);
    let poses: Vec<Vec<DMat3>> = (0..POSES)
        .map(|_| random_pose(digits, &mut random, 0.6))
        .collect();
    let samples: Vec<(Vec<f64>, Vec<DVec3>)> = par_map(POSES, |n| {
        let frames = skeleton.forward_kinematics(&poses[n], skeleton.joints[0]);
        let feature = pose_feature(&skeleton.parents, &frames);
        (feature, corrections(model, &skeleton, &frames))
    });
    let mut groups: BTreeMap<Vec<usize>, Vec<usize>> = BTreeMap::new();
    for (v, row) in model.weights.iter().enumerate() {
        groups
            .entry(active_joints(&model.parents, row))
            .or_default()
            .push(v);
    }
    let mut columns = vec![vec![DVec3::ZERO; model.template.len()]; features];
    for (joints, vertices) in groups {
        let active: Vec<usize> = joints.iter().flat_map(|j| 9 * (j - 1)..9 * j).collect();
        if active.is_empty() {
            continue;
        }
        let solution = ridge(&samples, &active, &vertices)?;
        for (&v, coefficients) in vertices.iter().zip(&solution) {
            for (&k, c) in active.iter().zip(coefficients) {
                columns[k][v] = *c;
            }
        }
    }
    Ok(columns)
}

/// argmin Σ |Fᵀ c − Δ|² + ridge |c|² over the active features, for each of the vertices.
fn ridge(
    samples: &[(Vec<f64>, Vec<DVec3>)],
    active: &[usize],
    vertices: &[usize],
) -> Result<Vec<Vec<DVec3>>> {
    let gathered: Vec<Vec<f64>> = samples
        .iter()
        .map(|(feature, _)| active.iter().map(|&k| feature[k]).collect())
        .collect();
    let product = |a: usize, b: usize| gathered.iter().map(|f| f[a] * f[b]).sum::<f64>();
    let count = active.len();
    let mut gram: Vec<Vec<f64>> = (0..count)
        .map(|a| (0..count).map(|b| product(a, b)).collect())
        .collect();
    let trace: f64 = (0..count).map(|a| gram[a][a]).sum();
    for (a, column) in gram.iter_mut().enumerate() {
        column[a] += RIDGE * trace / count as f64;
    }
    let factor = DenseFactor::new(&gram, "pose blend shapes")?;
    Ok(par_map(vertices.len(), |n| {
        let v = vertices[n];
        let mut out = vec![DVec3::ZERO; count];
        for axis in 0..3 {
            let moment = |a: usize| {
                let terms = gathered.iter().zip(samples);
                terms.map(|(f, (_, delta))| f[a] * delta[v][axis]).sum()
            };
            let right: Vec<f64> = (0..count).map(moment).collect();
            for (c, value) in out.iter_mut().zip(factor.solve(&right)) {
                c[axis] = value;
            }
        }
        out
    }))
}
