//! Skin weights from a partition: each vertex starts with one bone, and two implicit steps of heat flow
//! along the surface blend them. Heat stays on the surface, so a neighbour finger gets none however near
//! it is.

use super::field::smoothstep;
use supple::Result;
use supple::internal::math::Rows;
use supple::model::{SkinWeight, Surface};
use supple_bake::math::{SparseFactor, SparseSymmetric};

/// Bones a vertex may have.
const MOST: usize = 4;
/// Weights below the first are dropped, above the second kept; smooth in between.
const CUTOFF: [f64; 2] = [0.03, 0.10];

/// Entries of M + L: lumped areas and the cotangent form of ∫ r² ∇u·∇v, r the radius of the blend.
fn diffusion(skin: &Surface, areas: &[f64], radius: &[f64]) -> SparseSymmetric {
    let mut entries: Vec<(u32, u32, f64)> = areas
        .iter()
        .enumerate()
        .map(|(v, &area)| (v as u32, v as u32, area))
        .collect();
    for t in &skin.triangles {
        for k in 0..3 {
            let [a, b, c] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
            let [u, v] = [a, b].map(|i| skin.positions[i as usize] - skin.positions[c as usize]);
            // Clamped, so that weights stay between 0 and 1 (maximum principle).
            let cotangent = (u.dot(v) / u.cross(v).length()).clamp(0.05, 5.0);
            let r = 0.5 * (radius[a as usize] + radius[b as usize]);
            let stiffness = 0.5 * cotangent * r * r;
            entries.push((a, a, stiffness));
            entries.push((b, b, stiffness));
            entries.push((a.max(b), a.min(b), -stiffness));
        }
    }
    SparseSymmetric::from_entries(areas.len(), &entries)
}

/// At most four of `bones` bones for each vertex, with Σ w = 1, from each vertex's own bone and the radius
/// of the blend there.
pub(super) fn heat_weights(
    skin: &Surface,
    bones: usize,
    bone: &[usize],
    radius: &[f64],
) -> Result<Rows<SkinWeight>> {
    let areas = skin.vertex_areas();
    let factor = SparseFactor::new(&diffusion(skin, &areas, radius), "skin weights")?;
    // One implicit step of heat flow: (M + L) w = M u.
    let step = |columns: &[Vec<f64>]| {
        factor.solve_each(
            columns.len(),
            |j, b| (0..b.len()).for_each(|v| b[v] = areas[v] * columns[j][v]),
            |_, w| w.to_vec(),
        )
    };
    let start: Vec<Vec<f64>> = (0..bones)
        .map(|j| bone.iter().map(|&b| f64::from(u8::from(b == j))).collect())
        .collect();
    let columns = step(&step(&start));
    let rows = (0..skin.positions.len())
        .map(|v| {
            let mut row: Vec<(u32, f64)> = columns
                .iter()
                .enumerate()
                .map(|(j, c)| (j as u32, c[v]))
                .map(|(j, w)| (j, w * smoothstep((w - CUTOFF[0]) / (CUTOFF[1] - CUTOFF[0]))))
                .filter(|&(_, w)| w > 0.0)
                .collect();
            row.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
            row.truncate(MOST);
            let sum: f64 = row.iter().map(|r| r.1).sum();
            row.sort_by_key(|r| r.0);
            row.into_iter()
                .map(|(bone, w)| SkinWeight {
                    bone,
                    weight: w / sum,
                })
                .collect::<Vec<_>>()
        })
        .collect();
    Ok(rows)
}
