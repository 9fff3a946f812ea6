//! Values on a skin without what is small, whatever the size of its triangles.

use crate::math::{SparseFactor, SparseSymmetric};
use glam::DVec3;
use supple::Result;
use supple::model::Surface;

/// Greatest cotangent that counts: needles would tie their ends together.
const MOST_COTANGENT: f64 = 10.0;

/// S = (M + L)⁻¹ M, the implicit step of diffusion over a length h that varies over the skin (Desbrun et al. 1999):
/// M is the area of each vertex, and L the Laplacian of weights h_u h_v (cot α + cot β)/2.
pub(super) struct SkinFilter {
    areas: Vec<f64>,
    factor: SparseFactor,
}

impl SkinFilter {
    /// Over the length `lengths[v]` at each vertex, m.
    ///
    /// # Errors
    /// [`supple::Error::Solve`] where a number is not finite.
    pub fn new(skin: &Surface, lengths: &[f64]) -> Result<Self> {
        let mut areas = skin.vertex_areas();
        // Vertices of no area keep what they have, as nearly as makes no difference.
        let least = 1e-9 * areas.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        areas.iter_mut().for_each(|a| *a = a.max(least));
        let mut entries: Vec<(u32, u32, f64)> =
            areas.iter().zip(0..).map(|(a, v)| (v, v, *a)).collect();
        for (t, triangle) in skin.triangles.iter().enumerate() {
            let corners = skin.corners(t);
            for k in 0..3 {
                let [u, v] = [triangle[(k + 1) % 3], triangle[(k + 2) % 3]];
                let [a, b] = [1, 2].map(|i| corners[(k + i) % 3] - corners[k]);
                let cotangent = a.dot(b) / a.cross(b).length();
                // Not a number where the triangle is a point.
                let weight = 0.5 * cotangent.clamp(0.0, MOST_COTANGENT).max(0.0);
                let weight = weight * lengths[u as usize] * lengths[v as usize];
                entries.extend([
                    (u, u, weight),
                    (v, v, weight),
                    (u.max(v), u.min(v), -weight),
                ]);
            }
        }
        let matrix = SparseSymmetric::from_entries(areas.len(), &entries);
        Ok(Self {
            areas,
            factor: SparseFactor::new(&matrix, "smoothing of the skin")?,
        })
    }

    /// S x.
    pub fn smooth(&self, x: &[DVec3]) -> Vec<DVec3> {
        let load = |axis: usize, b: &mut [f64]| {
            let loads = x.iter().zip(&self.areas).map(|(x, area)| area * x[axis]);
            b.iter_mut().zip(loads).for_each(|(b, load)| *b = load);
        };
        let solved = self.factor.solve_each(3, load, |_, u| u.to_vec());
        (0..x.len())
            .map(|v| DVec3::from_array([0, 1, 2].map(|axis| solved[axis][v])))
            .collect()
    }

    /// (2 S − S²) x: what is smaller than the length goes, and what is larger stays, to first order.
    pub fn without_small(&self, x: &[DVec3]) -> Vec<DVec3> {
        let once = self.smooth(x);
        let twice = self.smooth(&once);
        once.iter().zip(twice).map(|(s, t)| 2.0 * *s - t).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tube of radius 1 and length 12, of rings of 48 vertices, finer in its middle.
    fn tube() -> Surface {
        let rings = 121;
        let height = |r: usize| {
            let u = r as f64 / 60.0 - 1.0;
            6.0 * u * (0.3 + 0.7 * u * u)
        };
        let place = |i: usize| {
            let (y, x) = (std::f64::consts::TAU * (i % 48) as f64 / 48.0).sin_cos();
            DVec3::new(x, y, height(i / 48))
        };
        let triangles = (0..48 * (rings - 1)).flat_map(|i| {
            let next = |i: usize| i / 48 * 48 + (i + 1) % 48;
            let [a, b, c, d] = [i, next(i), next(i) + 48, i + 48].map(|v| v as u32);
            [[a, b, c], [a, c, d]]
        });
        Surface {
            positions: (0..48 * rings).map(place).collect(),
            triangles: triangles.collect(),
        }
    }

    #[test]
    fn waves_fade_as_diffusion_says_however_fine_the_mesh_is() {
        let skin = tube();
        let length = 0.4;
        let filter = SkinFilter::new(&skin, &vec![length; skin.positions.len()]).unwrap();
        for wave in [1.0, 4.0] {
            let values: Vec<DVec3> = (skin.positions.iter())
                .map(|p| DVec3::new((wave * p.z).cos(), 1.0, p.x))
                .collect();
            let smooth = filter.smooth(&values);
            let without = filter.without_small(&values);
            // 1/(1 + h² k²) where the ends are far away.
            let s = 1.0 / (1.0 + length * length * wave * wave);
            let round = 1.0 / (1.0 + length * length);
            let inner = (0..values.len()).filter(|&v| skin.positions[v].z.abs() < 2.5);
            for v in inner {
                let expected = DVec3::new(s * values[v].x, 1.0, round * values[v].z);
                assert!(
                    smooth[v].distance(expected) < 0.02,
                    "{wave}: {} {expected}",
                    smooth[v]
                );
                assert!((without[v].x - (2.0 - s) * s * values[v].x).abs() < 0.03);
            }
        }
    }

    #[test]
    fn triangles_without_area_do_no_harm() {
        let mut skin = tube();
        skin.positions.extend([DVec3::ONE; 2]);
        let last = skin.positions.len() as u32 - 1;
        skin.triangles
            .extend([[last, last, last], [0, 1, 1], [0, 1, last]]);
        skin.positions[last as usize] = skin.positions[0].lerp(skin.positions[1], 0.5);
        let filter = SkinFilter::new(&skin, &vec![0.3; skin.positions.len()]).unwrap();
        assert!(filter.smooth(&skin.positions).iter().all(|p| p.is_finite()));
    }
}
