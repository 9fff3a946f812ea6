//! Pose blend shapes that give back what linear blending loses at bent joints.
//!
//! Linear blending shortens the way across a bent joint and folds volume away (the "candy wrapper" and
//! the "collapsing elbow"); blending dual quaternions keeps sections rigid (Kavan et al. 2007). For
//! seeded random poses the difference between the two, taken back to unposed space,
//!
//!   Δ_v(θ) = B_v⁻¹ ( x_dual(v, θ) − x_linear(v, θ) ),   B_v = Σ_j w_vj R_j,
//!
//! plus a bulge on the compressed side that makes up, as far as [`Bends::most_bulge`] allows, for the volume
//! still missing (a joint behind the middle of its section loses some even when sections stay rigid),
//! is fitted by ridge regression with SMPL's feature f(θ) (rows of R_parentᵀ R_child − I). A vertex uses
//! only the features of joints between its own bones, so every column is local and vanishes at rest.
//! Each fitted pose bends one joint; poses that bend many are predicted, and tests hold them out.

use super::dual_quaternion::dual_quaternion_skin;
use glam::{DMat3, DVec3};
use std::collections::BTreeMap;
use supple::Result;
use supple::internal::features::pose_feature;
use supple::internal::math::{Random, par_map, rotation_log};
use supple::model::{Frame, Skeleton, SkinWeight, Surface};
use supple_bake::ParametricModel;
use supple_bake::math::DenseFactor;

/// Poses fitted for each joint, and their seed.
const POSES: usize = 24;
const SEED: u64 = 0x5eed_0001;
/// Ridge, relative to the mean square of a feature: nine numbers describe a joint that mostly turns
/// about one axis, so the fit is ill-posed without it.
const RIDGE: f64 = 2e-3;

/// How a body bends.
pub(super) trait Bends: Sync {
    /// The most that a bulge may rise, m.
    fn most_bulge(&self) -> f64;

    /// A random rotation that joint `j` can take relative to its parent.
    fn random(&self, random: &mut Random, j: usize) -> DMat3;

    /// Unit direction of the bone that joint `j` moves.
    fn along(&self, j: usize) -> DVec3;
}

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
        blend.inverse() * difference
    };
    model
        .template
        .iter()
        .zip(model.weights.iter())
        .map(correct)
        .collect()
}

/// The volume of the model in a pose with `unposed` vertices.
fn posed_volume(
    model: &ParametricModel,
    skeleton: &Skeleton,
    frames: &[Frame],
    unposed: &[DVec3],
) -> f64 {
    let skin = |(x, row): (&DVec3, &[SkinWeight])| {
        let place = |w: &SkinWeight| {
            let j = w.bone as usize;
            w.weight * frames[j].transform(*x - skeleton.joints[j])
        };
        row.iter().map(place).sum()
    };
    Surface {
        positions: unposed.iter().zip(model.weights.iter()).map(skin).collect(),
        triangles: model.triangles.clone(),
    }
    .volume()
}

/// The share of joint `j`'s bulge at each vertex, in 0..1: where both sides of the joint meet, on the
/// side that `rotation` compresses.
fn bulge_shape(
    model: &ParametricModel,
    normals: &[DVec3],
    j: usize,
    along: DVec3,
    rotation: DMat3,
) -> Vec<f64> {
    let axis = rotation_log(rotation).normalize_or_zero();
    let share = |(row, &n): (&[SkinWeight], &DVec3)| {
        let below: f64 = row
            .iter()
            .filter(|w| is_above(&model.parents, j as u32, w.bone))
            .map(|w| w.weight)
            .sum();
        // A point at offset n moves by axis × n: against the bone where it is compressed.
        let compressed = ((0.2 - axis.cross(n).dot(along)) / 0.8).clamp(0.0, 1.0);
        4.0 * below * (1.0 - below) * compressed
    };
    model.weights.iter().zip(normals).map(share).collect()
}

/// The fitted columns: `[feature][vertex]`.
pub(super) fn pose_columns(model: &ParametricModel, bends: &dyn Bends) -> Result<Vec<Vec<DVec3>>> {
    let skeleton = model.skeleton(&[]);
    let features = 9 * (skeleton.len() - 1);
    let mut random = Random::new(SEED);
    let poses: Vec<(usize, DMat3)> = (0..POSES * (skeleton.len() - 1))
        .map(|n| {
            let j = 1 + n / POSES;
            (j, bends.random(&mut random, j))
        })
        .collect();
    let rest = Surface {
        positions: model.template.clone(),
        triangles: model.triangles.clone(),
    };
    let (normals, areas, volume) = (rest.vertex_normals(), rest.vertex_areas(), rest.volume());
    let samples: Vec<(Vec<f64>, Vec<DVec3>)> = par_map(poses.len(), |n| {
        let (j, rotation) = poses[n];
        let mut local = vec![DMat3::IDENTITY; skeleton.len()];
        local[j] = rotation;
        let frames = skeleton.forward_kinematics(&local, skeleton.joints[0]);
        let mut delta = corrections(model, &skeleton, &frames);
        let unposed: Vec<DVec3> = delta
            .iter()
            .zip(&model.template)
            .map(|(d, x)| *d + *x)
            .collect();
        let missing = volume - posed_volume(model, &skeleton, &frames, &unposed);
        let shape = bulge_shape(model, &normals, j, bends.along(j), rotation);
        let swept: f64 = shape.iter().zip(&areas).map(|(s, a)| s * a).sum();
        let height = (missing / swept.max(1e-9)).clamp(0.0, bends.most_bulge());
        for ((d, s), n) in delta.iter_mut().zip(&shape).zip(&normals) {
            *d += height * *s * *n;
        }
        (pose_feature(&skeleton.parents, &frames), delta)
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
