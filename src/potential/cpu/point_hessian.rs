//! A cubature point's part of the Hessian: for blocks a ≥ b of its local order (c and ω of each bone,
//! then the handles)
//!
//! ```text
//! H_ab = J_aᵀ (m/h²) J_b + w (∇U_aᵀ ⊗ I) C (∇U_b ⊗ I)
//! J_c = w_j I      J_ω = −[a_j]×      J_φ = B N_h
//! ```

use super::Basis;
use crate::math::{Mat9, skew};
use crate::model::SkinWeight;
use glam::{DMat3, DVec3};

/// What an evaluation knows of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointTerms {
    /// m/h², N/m.
    pub inertia: f64,
    /// f, N: see [`super::gradient`](mod@super::gradient).
    pub force: DVec3,
    /// Bᵀ f, N.
    pub pulled_force: DVec3,
    /// w P, J.
    pub stress: DMat3,
    /// (m/h²) B, N/m.
    pub blended: DMat3,
    /// (m/h²) Bᵀ B, N/m.
    pub metric: DMat3,
}

/// A point with everything its blocks are made of.
#[derive(Clone, Copy, Debug)]
pub struct PointView<'a, B> {
    /// Its numbers.
    pub terms: &'a PointTerms,
    /// Its bones.
    pub skinning: &'a [SkinWeight],
    /// a_j = w_j R_j (T − J_j), m, of each bone.
    pub arms: &'a [DVec3],
    /// Its handles.
    pub basis: &'a [B],
    /// w C, J.
    pub tangent: &'a Mat9,
    /// By frame: whose blocks are left out.
    pub prescribed: &'a [bool],
}

/// Whether `block` is one of a prescribed frame's.
pub fn is_prescribed(prescribed: &[bool], block: usize) -> bool {
    prescribed.get(block / 2).is_some_and(|p| *p)
}

/// Hands the blocks (`local`, b) for b = 0..=`local`, less those of prescribed frames, to `each`, in order, each column
/// by column.
#[inline]
pub fn hessian_row<B: Basis>(
    point: &PointView<'_, B>,
    local: usize,
    mut each: impl FnMut(usize, [f64; 9]),
) {
    let frames = 2 * point.skinning.len();
    if local >= frames {
        handle_row(point, local - frames, each);
        return;
    }
    let inertia = point.terms.inertia;
    let (weight, arm) = (point.skinning[local / 2].weight, point.arms[local / 2]);
    let is_rotation = local % 2 == 1;
    for (k, (w, &other)) in point.skinning.iter().zip(point.arms).enumerate() {
        if 2 * k > local {
            break;
        }
        if is_prescribed(point.prescribed, 2 * w.bone as usize) {
            continue;
        }
        let translation = if is_rotation {
            skew(arm * (inertia * w.weight))
        } else {
            DMat3::from_diagonal(DVec3::splat(inertia * weight * w.weight))
        };
        each(2 * k, translation.to_cols_array());
        if 2 * k + 1 > local {
            break;
        }
        let rotation = if is_rotation {
            // [a]×ᵀ[b]× = (a·b) I − b aᵀ
            let b = other * inertia;
            DMat3::from_diagonal(DVec3::splat(arm.dot(b)))
                - DMat3::from_cols(b * arm.x, b * arm.y, b * arm.z)
        } else {
            skew(other * (-inertia * weight))
        };
        each(2 * k + 1, rotation.to_cols_array());
    }
}

#[inline]
fn handle_row<B: Basis>(point: &PointView<'_, B>, h: usize, mut each: impl FnMut(usize, [f64; 9])) {
    let own = &point.basis[h];
    let x = own.after(point.terms.blended).transpose();
    for (k, (w, a)) in point.skinning.iter().zip(point.arms).enumerate() {
        if is_prescribed(point.prescribed, 2 * w.bone as usize) {
            continue;
        }
        each(2 * k, (x * w.weight).to_cols_array());
        // −X [a]×
        each(
            2 * k + 1,
            DMat3::from_cols(
                x.z_axis * a.y - x.y_axis * a.z,
                x.x_axis * a.z - x.z_axis * a.x,
                x.y_axis * a.x - x.x_axis * a.y,
            )
            .to_cols_array(),
        );
    }
    let first = 2 * point.skinning.len();
    let stiffness = own.stiffness(point.tangent);
    let metric = own.before(point.terms.metric);
    for (k, other) in point.basis[..=h].iter().enumerate() {
        each(first + k, other.block(metric, &stiffness));
    }
}

/// All blocks of the point, (a, b ≤ a) at a(a + 1)/2 + b.
pub fn point_hessian<B: Basis>(point: &PointView<'_, B>, out: &mut [DMat3]) {
    let count = 2 * point.skinning.len() + point.basis.len();
    for a in 0..count {
        hessian_row(point, a, |b, block| {
            out[a * (a + 1) / 2 + b] = DMat3::from_cols_array(&block);
        });
    }
}
