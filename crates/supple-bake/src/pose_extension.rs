//! How cubature points follow offsets of the skin: rows of the harmonic extension that pose blend shapes reach them by.

use crate::interior::InteriorField;
use supple::internal::math::Rows;
use supple::model::TetMesh;

/// Σ |E| of the entries that a row loses. Those of a prism shell hardly lose any: its nodes are skin or bone. A hand's, which
/// hang on much of the skin around a deep point, are then wrong by 0.4 % of what moves them at most.
const LOST: f64 = 5e-3;

/// E: skin vertices (index, share) whose offsets the centroids of `tets` follow, vertices rising.
pub(crate) fn pose_extension(
    field: &InteriorField<'_>,
    mesh: &TetMesh,
    tets: &[u32],
) -> Rows<(u32, f32)> {
    let centroid = |i: usize| mesh.tets[tets[i] as usize].map(|node| (node, 0.25));
    let rows = field.skin_shares(tets.len(), centroid, truncated);
    rows.into_iter().collect()
}

/// The largest entries of a row. They take what is lost in proportion to their size, so that offsets which are the same all
/// over the skin are extended as by the whole row.
fn truncated(row: &[f64]) -> Vec<(u32, f32)> {
    let size = |v: &u32| row[*v as usize].abs();
    let mut order: Vec<u32> = (0..row.len() as u32).filter(|v| size(v) > 0.0).collect();
    order.sort_by(|a, b| size(b).total_cmp(&size(a)).then(a.cmp(b)));
    let (mut kept, mut lost) = (order.len(), 0.0);
    while kept > 1 && lost + size(&order[kept - 1]) <= LOST {
        kept -= 1;
        lost += size(&order[kept]);
    }
    let (kept, dropped) = order.split_at_mut(kept);
    kept.sort_unstable();
    let missing: f64 = dropped.iter().map(|&v| row[v as usize]).sum();
    let whole: f64 = kept.iter().map(size).sum();
    let share = |&v: &u32| (v, (row[v as usize] + missing * size(&v) / whole) as f32);
    kept.iter().map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_loses_its_smallest_entries_and_keeps_its_sum() {
        let row = [0.0, 0.4, -3e-3, 1.5e-3, -0.1, 1e-3, 0.2, 5e-4];
        let short = truncated(&row);
        let vertices: Vec<u32> = short.iter().map(|e| e.0).collect();
        assert_eq!(vertices, [1, 2, 4, 6]);
        let sum = |short: &[(u32, f32)]| -> f64 { short.iter().map(|e| f64::from(e.1)).sum() };
        assert!((sum(&short) - row.iter().sum::<f64>()).abs() < 1e-7);
        assert!((f64::from(short[0].1) / 0.4 - 1.0).abs() < 1e-2);
        // One that is all small keeps the largest, which takes the sum; one of zeros is empty.
        assert_eq!(truncated(&[1e-5, 3e-5]), [(1, 4e-5)]);
        assert_eq!(truncated(&[0.0, 0.0]), []);
    }
}
