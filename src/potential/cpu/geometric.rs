//! The geometric terms of contact: Σ f · ∂²z/∂q² over the contacts' rows, f = ∂E/∂z, which Gauss–Newton drops:
//!
//! ```text
//! (ω_j, ω_j): ½ (f a_jᵀ + a_j fᵀ) − (f·a_j) I      (ω_j, φ_h): −w_j [f]× R_j N_h
//! ```
//!
//! and, seen from a body, z = exp(−\[δω\]) (x − c): (ω, ω) as a bone's with r = x − c, (ω, b): \[f\]× ∂z/∂q_b.
//! With them the Hessian may be indefinite. Rows read back from a GPU are assembled here as well.

use super::Basis;
use super::contact::ContactRow;
use super::displacement::{blended_rotation, position};
use super::point_hessian::is_prescribed;
use crate::math::skew;
use crate::model::{BasisEntry, Frame, SkinWeight};
use crate::potential::BlockPattern;
use glam::{DMat3, DVec3};

/// The vertex of a row, and what moves it.
pub struct Vertex<'a, B> {
    /// Its bones.
    pub skinning: &'a [SkinWeight],
    /// Its handles.
    pub basis: &'a [B],
    /// Those that are awake.
    pub fine: &'a [BasisEntry],
    /// T, m.
    pub unposed: DVec3,
}

/// Adds the terms of `row` to the packed blocks `out`, less those of frames that are `prescribed`.
pub fn add_geometric<B: Basis>(
    (pattern, prescribed): (&BlockPattern, &[bool]),
    row: &ContactRow,
    vertex: &Vertex<'_, B>,
    joints: &[DVec3],
    frames: &[Frame],
    out: &mut [[f64; 9]],
) {
    let (f, space) = (row.force * row.direction, pattern.space());
    let mut add = |row: usize, column: usize, block: DMat3| {
        if is_prescribed(prescribed, row) || is_prescribed(prescribed, column) {
            return;
        }
        let (high, low, block) = if row >= column {
            (row, column, block)
        } else {
            (column, row, block.transpose())
        };
        // The pattern has every pair of blocks that one contact moves.
        if let Some(k) = pattern.find(high, low) {
            for (sum, term) in out[k].iter_mut().zip(block.to_cols_array()) {
                *sum += term;
            }
        }
    };
    for w in vertex.skinning {
        let j = w.bone as usize;
        let rotation = frames[j].rotation;
        let arm = w.weight * (rotation * (vertex.unposed - joints[j]));
        let omega = space.frame_block(j) + 1;
        add(omega, omega, turned(f, arm));
        for n in vertex.basis {
            let mixed = n.after(skew(f) * rotation * -w.weight);
            add(omega, space.handle_block(n.handle()), mixed);
        }
        for n in vertex.fine {
            let mixed = n.after(skew(f) * rotation * -w.weight);
            add(omega, space.handle_block(Basis::handle(n)), mixed);
        }
    }
    let Some(body) = row.body else { return };
    let c = space.frame_block(body as usize);
    let omega = c + 1;
    let point = position(vertex.skinning, joints, frames, vertex.unposed);
    let r = point - frames[body as usize].position;
    add(omega, omega, turned(f, r));
    add(omega, c, -skew(f));
    for w in vertex.skinning {
        let j = w.bone as usize;
        let arm = w.weight * (frames[j].rotation * (vertex.unposed - joints[j]));
        let block = space.frame_block(j);
        add(omega, block, skew(f) * w.weight);
        add(omega, block + 1, -(skew(f) * skew(arm)));
    }
    let pulled = skew(f) * blended_rotation(vertex.skinning, frames);
    for n in vertex.basis {
        add(omega, space.handle_block(n.handle()), n.after(pulled));
    }
    for n in vertex.fine {
        add(omega, space.handle_block(Basis::handle(n)), n.after(pulled));
    }
}

/// ½ (f aᵀ + a fᵀ) − (f·a) I.
fn turned(f: DVec3, a: DVec3) -> DMat3 {
    let outer = DMat3::from_cols(f * a.x, f * a.y, f * a.z);
    (outer + outer.transpose()) * 0.5 - DMat3::from_diagonal(DVec3::splat(f.dot(a)))
}
