//! The joint regressor: each joint as a combination of the skin vertices around it, exact for the
//! template and close under every shape direction.

use glam::DVec3;
use supple::Result;
use supple::internal::math::Rows;
use supple::model::{SkinWeight, Surface};
use supple_bake::math::DenseFactor;

/// Weight of a joint's motion under shape directions against its place in the template: a tenth
/// of a millimetre in one unit matters as much as a micrometre there.
const SHAPE_SHARE: f64 = 1e-1;
/// Tikhonov term against huge coefficients, relative to the trace.
const RIDGE: f64 = 1e-12;

fn share(row: &[SkinWeight], bone: usize) -> f64 {
    row.iter()
        .filter(|w| w.bone as usize == bone)
        .map(|w| w.weight)
        .sum()
}

/// How much a vertex with these weights belongs to the ring around the joint between two bones.
pub(super) fn ring_share(row: &[SkinWeight], bone: usize, parent: usize) -> f64 {
    4.0 * share(row, bone) * share(row, parent)
}

/// Over the vertices v of `closeness(j, v)` > 0.1, the minimum-norm coefficients a (Σ a²/closeness) with Σ a = 1, Σ a x = J and, for every shape
/// direction, Σ a d = δJ: a = C Bᵀ (B C Bᵀ)⁻¹ b.
pub(super) fn joint_regressor(
    skin: &Surface,
    closeness: impl Fn(usize, usize) -> f64,
    joints: &[DVec3],
    directions: &[Vec<DVec3>],
    joint_motions: &[Vec<DVec3>],
) -> Result<Rows<(u32, f64)>> {
    let mut rows = Vec::with_capacity(joints.len());
    for (j, &joint) in joints.iter().enumerate() {
        let ring: Vec<(usize, f64)> = (0..skin.positions.len())
            .map(|v| (v, closeness(j, v)))
            .filter(|&(_, c)| c > 0.1)
            .collect();
        let constraints = 4 + 3 * directions.len();
        let column = |v: usize| {
            let mut c = vec![1.0];
            // About the joint, in cm: all constraints of similar size.
            c.extend((0.1 * (skin.positions[v] - joint)).to_array());
            for d in directions {
                c.extend((SHAPE_SHARE * d[v]).to_array());
            }
            c
        };
        let mut right = vec![1.0, 0.0, 0.0, 0.0];
        for motion in joint_motions {
            right.extend((SHAPE_SHARE * motion[j]).to_array());
        }
        let columns: Vec<Vec<f64>> = ring.iter().map(|&(v, _)| column(v)).collect();
        let mut gram = vec![vec![0.0; constraints]; constraints];
        for (c, &(_, closeness)) in columns.iter().zip(&ring) {
            for a in 0..constraints {
                for b in 0..constraints {
                    gram[a][b] += closeness * c[a] * c[b];
                }
            }
        }
        let trace: f64 = (0..constraints).map(|a| gram[a][a]).sum();
        for (a, row) in gram.iter_mut().enumerate() {
            row[a] += RIDGE * trace;
        }
        let multiplier = DenseFactor::new(&gram, "joint regressor")?.solve(&right);
        rows.push(
            ring.iter()
                .zip(&columns)
                .map(|(&(v, closeness), c)| {
                    let value: f64 = (0..constraints).map(|a| c[a] * multiplier[a]).sum();
                    (v as u32, closeness * value)
                })
                .collect::<Vec<_>>(),
        );
    }
    Ok(rows.into_iter().collect())
}
