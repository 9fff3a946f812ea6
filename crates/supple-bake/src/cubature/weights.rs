//! Cubature weights corrected so that they keep given moments of the tissue.

use super::cubature::Tissue;
use crate::math::DenseFactor;
use supple::internal::math::Rows;

/// Moments that weights should keep, Σ_i w_i g_{k,i} = target_k: first the tissue's first moment and volume, which
/// are kept to rounding, then each handle's ∫ s |∇U_h|², which gives way where too few points see the handle.
#[derive(Debug)]
pub(crate) struct Moments {
    /// (k, g) of each point, k rising.
    rows: Rows<(u32, f64)>,
    /// Target of each moment.
    target: Vec<f64>,
    /// By how much a moment may be missed for each unit of its multiplier; 0: not at all.
    slack: Vec<f64>,
}

/// First moment and volume.
const EXACT: usize = 4;
/// Slack of a handle's moment, relative to its target.
const SLACK: f64 = 0.01;
/// The exponents of a good sample stay near 1, and Newton takes some ten iterations.
const MOST_ITERATIONS: usize = 50;

impl Moments {
    /// Those of `tissue`, for points in `tets`; `slopes` is (handle, s |∇U_h|²) of each tet of the mesh, s
    /// the factor on the stiffness.
    pub fn of(tissue: Tissue<'_>, tets: &[u32], slopes: &Rows<(u32, f64)>) -> Self {
        let mesh = tissue.mesh;
        let handles = (slopes.entries().iter()).map(|s| s.0 as usize + 1).max();
        let handles = handles.unwrap_or(0);
        let (mut sum, mut square) = (vec![0.0; handles], vec![0.0; handles]);
        for (volume, row) in tissue.tet_volumes().into_iter().zip(slopes.iter()) {
            for &(handle, slope) in row {
                sum[handle as usize] += volume * slope;
                square[handle as usize] += volume * slope * slope;
            }
        }
        // With g = s |∇U_h|²: in units of ∫ g² / ∫ g every handle's moment is about 1 where the handle is.
        let unit: Vec<f64> = sum.iter().zip(&square).map(|(s, q)| q / s).collect();
        let (volume, first) = tissue.moments();
        let (mean, size) = (first / volume, volume.cbrt());
        let mut moments = Self {
            rows: Rows::default(),
            target: vec![0.0, 0.0, 0.0, volume],
            slack: vec![0.0; EXACT],
        };
        for (s, unit) in sum.iter().zip(&unit) {
            let target = if *s > 0.0 { s / unit } else { 0.0 };
            moments.target.push(target);
            moments.slack.push((SLACK * target).max(f64::MIN_POSITIVE));
        }
        for &t in tets {
            let y = (mesh.centroid(t as usize) - mean) / size;
            let mut row = vec![(0, y.x), (1, y.y), (2, y.z), (3, 1.0)];
            let steep = slopes.row(t as usize).iter().filter(|s| s.1 > 0.0);
            row.extend(steep.map(|s| (EXACT as u32 + s.0, s.1 / unit[s.0 as usize])));
            moments.rows.push(row);
        }
        moments
    }

    /// Volume and first moment alone.
    pub fn exact_only(&self) -> Self {
        let exact = |row: &[(u32, f64)]| row[..EXACT].to_vec();
        Self {
            rows: self.rows.iter().map(exact).collect(),
            target: self.target[..EXACT].to_vec(),
            slack: self.slack[..EXACT].to_vec(),
        }
    }

    /// Σ w g − target.
    fn errors(&self, weights: &[f64]) -> Vec<f64> {
        let mut errors: Vec<f64> = self.target.iter().map(|t| -t).collect();
        for (w, row) in weights.iter().zip(self.rows.iter()) {
            row.iter().for_each(|&(k, g)| errors[k as usize] += w * g);
        }
        errors
    }

    /// Root mean square over the handles of the relative error of ∫ s |∇U_h|².
    pub fn stiffness_error(&self, weights: &[f64]) -> f64 {
        let errors = self.errors(weights).into_iter().zip(&self.target);
        let squares: Vec<f64> = (errors.skip(EXACT))
            .filter(|(_, target)| **target > 0.0)
            .map(|(error, target)| (error / target).powi(2))
            .collect();
        (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
    }
}

/// The weights nearest to the positive weights `prior` in relative entropy, Σ w log(w/w⁰) − w + w⁰, that have the
/// `moments`: w_i = w⁰_i exp(Σ_k λ_k g_{k,i}), positive whatever λ, which minimises the convex dual
/// Σ w − λ · target + ½ Σ slack λ² (Boyd and Vandenberghe, *Convex Optimization*, 2004, §5.1.6), by Newton's method.
/// `None` where no positive weights have the exact moments.
pub(crate) fn nearest_weights(prior: &[f64], moments: &Moments) -> Option<Vec<f64>> {
    let count = moments.target.len();
    let volume = moments.target[EXACT - 1];
    let weights = |lambda: &[f64]| -> Vec<f64> {
        let exponent = |row: &[(u32, f64)]| -> f64 {
            let terms = row.iter().map(|&(k, g)| lambda[k as usize] * g);
            terms.sum()
        };
        let exponents = moments.rows.iter().map(exponent);
        prior
            .iter()
            .zip(exponents)
            .map(|(w, e)| w * e.exp())
            .collect()
    };
    let dual = |lambda: &[f64], weights: &[f64]| {
        let terms = lambda.iter().zip(&moments.target).zip(&moments.slack);
        let rest: f64 = terms.map(|((l, t), s)| 0.5 * s * l * l - l * t).sum();
        weights.iter().sum::<f64>() + rest
    };
    let mut lambda = vec![0.0; count];
    let mut w = weights(&lambda);
    for _ in 0..MOST_ITERATIONS {
        let mut gradient = moments.errors(&w);
        let yielding = gradient.iter_mut().zip(&moments.slack).zip(&lambda);
        yielding.for_each(|((g, s), l)| *g += s * l);
        let largest = gradient.iter().fold(0.0f64, |m, g| m.max(g.abs()));
        if largest <= 4.0 * f64::EPSILON * volume {
            break;
        }
        let step = DenseFactor::new(&dual_hessian(&w, moments), "cubature moments")
            .ok()?
            .solve(&gradient);
        let slope: f64 = step.iter().zip(&gradient).map(|(s, g)| s * g).sum();
        let value = dual(&lambda, &w);
        let shorter = (0..40).map(|n| 0.5f64.powi(n)).find_map(|length| {
            let moved = lambda.iter().zip(&step).map(|(l, s)| l - length * s);
            let moved: Vec<f64> = moved.collect();
            let w = weights(&moved);
            let rounding = 16.0 * f64::EPSILON * volume;
            let falls = dual(&moved, &w) <= value - 1e-4 * length * slope + rounding;
            falls.then_some((moved, w))
        });
        (lambda, w) = shorter?;
    }
    let errors = moments.errors(&w);
    let exact = errors[..EXACT].iter().all(|e| e.abs() <= 1e-13 * volume);
    (exact && w.iter().all(|w| *w > 0.0)).then_some(w)
}

/// Σ_i w_i g_i g_iᵀ + slack, as columns of which the lower triangle is set.
fn dual_hessian(weights: &[f64], moments: &Moments) -> Vec<Vec<f64>> {
    let count = moments.target.len();
    let mut columns = vec![vec![0.0; count]; count];
    for (w, row) in weights.iter().zip(moments.rows.iter()) {
        for (n, &(l, left)) in row.iter().enumerate() {
            for &(k, right) in &row[n..] {
                columns[l as usize][k as usize] += w * left * right;
            }
        }
    }
    for (k, slack) in moments.slack.iter().enumerate() {
        columns[k][k] += slack;
    }
    columns
}
