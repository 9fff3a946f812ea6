//! Truncation of the basis: a point then has four or five handles, and the Hessian is sparse.

use crate::sway::SwayProfile;
use serde::{Deserialize, Serialize};
use supple::internal::math::Rows;

/// |u| < `below` → 0, |u| > `above` kept, a smooth step in between (method: 0.03 and 0.1).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Truncation {
    /// Off keeps every value: more accurate, and dense.
    pub enabled: bool,
    /// Values below this vanish.
    pub below: f64,
    /// Values above this stay as they are.
    pub above: f64,
    /// Whether what is left of each row is scaled so that the tissue sways on its bones as far as it would with every
    /// node free, which truncation stiffens. Not said: where all handles stand on the skin. Handles in the volume
    /// follow the depth themselves, and dense ones press better without.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keep_sway: Option<bool>,
}

impl Default for Truncation {
    fn default() -> Self {
        Self {
            enabled: true,
            below: 0.03,
            above: 0.1,
            keep_sway: None,
        }
    }
}

impl Truncation {
    /// No truncation.
    pub const OFF: Self = Self {
        enabled: false,
        below: 0.03,
        above: 0.1,
        keep_sway: None,
    };

    /// The truncated value: u · s(t), s(t) = t²(3 − 2t), t = (|u| − below)/(above − below) in 0..1.
    pub fn apply(&self, u: f64) -> f64 {
        if !self.enabled {
            return u;
        }
        let t = ((u.abs() - self.below) / (self.above - self.below)).clamp(0.0, 1.0);
        u * t * t * (3.0 - 2.0 * t)
    }

    /// Truncates `columns` (one a handle, one value a node) into rows (one a node, handles rising),
    /// and measures the cost: the relative change √(Σ m (u' − u)² / Σ m u²), m the nodal measure. Then rows keep `sway`.
    pub(crate) fn rows(
        &self,
        columns: &[Vec<f64>],
        measure: &[f64],
        sway: Option<&SwayProfile>,
    ) -> (Rows<(u32, f64)>, f64) {
        let (mut changed, mut whole) = (0.0, 0.0);
        let mut rows = Rows::default();
        for (node, m) in measure.iter().enumerate() {
            let mut row = Vec::new();
            for (handle, column) in columns.iter().enumerate() {
                let (u, kept) = (column[node], self.apply(column[node]));
                changed += m * (kept - u).powi(2);
                whole += m * u * u;
                if kept != 0.0 {
                    row.push((handle as u32, kept));
                }
            }
            if let Some(sway) = sway {
                let scale = sway.scale(node, &row);
                row.iter_mut().for_each(|(_, u)| *u *= scale);
            }
            rows.push(row);
        }
        let cost = if whole > 0.0 {
            (changed / whole).sqrt()
        } else {
            0.0
        };
        (rows, cost)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_values_vanish_large_ones_stay_and_the_rest_is_smooth() {
        let truncation = Truncation::default();
        for (u, expected) in [(0.029, 0.0), (-0.029, 0.0), (0.1, 0.1), (-0.7, -0.7)] {
            assert_eq!(truncation.apply(u), expected);
        }
        assert_eq!(Truncation::OFF.apply(0.001), 0.001);
        // Continuous with a continuous slope: differences of neighbours never jump.
        let values: Vec<f64> = (0..=2000)
            .map(|i| truncation.apply(f64::from(i) * 1e-4))
            .collect();
        let bends = values.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs());
        // |(u s)''| ≤ 2 s' + u s'' ≤ 2·1.5/0.07 + 0.1·6/0.07² = 165, and 1.5/0.07 from the slope's
        // rise at `above` spread over one step.
        assert!(bends.fold(0.0, f64::max) <= 165.0 * 1e-8 * 1.01);
    }

    #[test]
    fn cost_is_the_relative_change() {
        let columns = vec![vec![0.5, 0.02], vec![0.0, 0.9]];
        let (rows, cost) = Truncation::default().rows(&columns, &[2.0, 2.0], None);
        assert_eq!(rows.row(0), [(0, 0.5)]);
        assert_eq!(rows.row(1), [(1, 0.9)]);
        let expected = 0.02 / (0.25f64 + 0.02 * 0.02 + 0.81).sqrt();
        assert!((cost - expected).abs() < 1e-15);
        assert_eq!(Truncation::OFF.rows(&columns, &[2.0, 2.0], None).1, 0.0);
    }
}
