//! Pose blend shapes: x̄_i = X_i + Σ_k feature_k column_k,i.

use crate::model::PoseBlend;
use glam::DVec3;

/// x̄ of the points `first..first + out.len()`; `position` is X of all points, `feature` is
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
