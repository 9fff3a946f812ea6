//! The unposed rest shape: x̄_i = X_i + Σ_k feature_k column_k,i + Σ_v E_iv u_v, where u are a host's offsets of the skin;
//! a skin vertex has its own.

use crate::model::PoseBlend;
use glam::DVec3;

/// X and the pose blend shapes of the points `first..first + out.len()`; `position` is X of all points, `feature` is
/// [`crate::model::pose_feature`] of the pose.
pub fn pose_blend(
    position: &[DVec3],
    blend: &PoseBlend,
    feature: &[f64],
    first: usize,
    out: &mut [DVec3],
) {
    let range = first..first + out.len();
    out.copy_from_slice(&position[range.clone()]);
    for (k, &value) in feature.iter().enumerate().take(blend.features) {
        // A bone at its rest rotation has nine zeros.
        if value == 0.0 {
            continue;
        }
        let columns = &blend.columns[k * position.len()..][range.clone()];
        let sums: &mut [f64] = bytemuck::cast_slice_mut(out);
        for (sum, &column) in sums.iter_mut().zip(columns.as_flattened()) {
            *sum += value * f64::from(column);
        }
    }
}

/// Σ_v E_v u_v of a point with `shares` E in the skin's `offsets` u, m.
pub fn pose_offset(shares: &[(u32, f32)], offsets: &[[f32; 3]]) -> DVec3 {
    let term = |&(v, share): &(u32, f32)| {
        f64::from(share) * DVec3::from(offsets[v as usize].map(f64::from))
    };
    shares.iter().map(term).sum()
}

/// Adds their own `offsets`, m, to x̄ of skin vertices; those of bodies have none.
pub fn add_offsets(rest: &mut [DVec3], offsets: &[[f32; 3]]) {
    for (x, offset) in rest.iter_mut().zip(offsets) {
        *x += DVec3::from(offset.map(f64::from));
    }
}
