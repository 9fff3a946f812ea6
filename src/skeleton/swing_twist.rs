//! Swing and twist of a rotation about an axis, with their derivatives.

use super::term::rotation_curvature;
use glam::{DMat3, DQuat, DVec3};

/// Q split about the unit vector a: the swing β is the angle from a to Qa; the twist
/// τ = 2 atan2(v·a, w), in (−π, π\], with Q's quaternion (w, v), w ≥ 0.
///
/// Derivatives are by ε in Q ← exp(\[ε\]) Q. Where β is 0 or π, β has no slope, and at π neither has τ:
/// 0 is given there.
pub(super) struct SwingTwist {
    axis: DVec3,
    /// Qa.
    turned: DVec3,
    /// w and v.
    quaternion: (f64, DVec3),
    /// β, rad.
    pub swing: f64,
    /// τ, rad.
    pub twist: f64,
}

/// Below it a sine is taken for 0.
const SINGULAR: f64 = 1e-9;

impl SwingTwist {
    pub fn new(rotation: DMat3, axis: DVec3) -> Self {
        let q = DQuat::from_mat3(&rotation).normalize();
        let q = if q.w < 0.0 { -q } else { q };
        let turned = rotation * axis;
        Self {
            axis,
            turned,
            quaternion: (q.w, q.xyz()),
            // Of acos and asin only atan2 keeps its digits everywhere.
            swing: axis.cross(turned).length().atan2(axis.dot(turned)),
            twist: 2.0 * q.xyz().dot(axis).atan2(q.w),
        }
    }

    /// ∂β = a × Qa / sin β.
    pub fn swing_slope(&self) -> DVec3 {
        let normal = self.axis.cross(self.turned);
        let sine = normal.length();
        if sine < SINGULAR {
            return DVec3::ZERO;
        }
        normal / sine
    }

    /// ∂²β = −(C + cos β n nᵀ)/sin β, C the curvature of a · Qa and n = ∂β.
    pub fn swing_curvature(&self) -> DMat3 {
        let sine = self.axis.cross(self.turned).length();
        if sine < SINGULAR {
            return DMat3::ZERO;
        }
        let n = self.swing_slope();
        let normal = DMat3::from_cols(n * n.x, n * n.y, n * n.z);
        let cosine = self.axis.dot(self.turned);
        (rotation_curvature(self.axis, self.turned) + normal * cosine) * -sine.recip()
    }

    /// w² + p² with p = v·a, and the slopes of τ and of half of it: with δw = −½ ε·v and
    /// δp = ½ ε·(w a + v × a), ∂τ = (w (w a + v × a) + p v)/(w² + p²).
    fn twist_parts(&self) -> Option<(f64, DVec3, DVec3)> {
        let (w, v) = self.quaternion;
        let p = v.dot(self.axis);
        let square = w * w + p * p;
        if square < SINGULAR * SINGULAR {
            return None;
        }
        let forth = w * self.axis + v.cross(self.axis);
        Some((
            square,
            (w * forth + p * v) / square,
            0.5 * (p * forth - w * v),
        ))
    }

    /// ∂τ.
    pub fn twist_slope(&self) -> DVec3 {
        self.twist_parts().map_or(DVec3::ZERO, |parts| parts.1)
    }

    /// ∂²τ = −(∂τ yᵀ + y ∂τᵀ)/(w² + p²), y = ½ ∂(w² + p²): w and p bend alike, by −¼|ε|² of themselves.
    pub fn twist_curvature(&self) -> DMat3 {
        let Some((square, t, y)) = self.twist_parts() else {
            return DMat3::ZERO;
        };
        let product = DMat3::from_cols(t * y.x, t * y.y, t * y.z);
        (product + product.transpose()) * -square.recip()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Random, rotation_exp};

    #[test]
    fn a_swing_and_a_twist_are_found_again() {
        let axis = DVec3::new(0.48, -0.6, 0.64);
        let across = axis.any_orthonormal_vector();
        for (swing, twist) in [(0.3, -1.2), (1.4, 0.7), (2.9, 2.0), (1e-3, 3.0)] {
            let q = rotation_exp(across * swing) * rotation_exp(axis * twist);
            let found = SwingTwist::new(q, axis);
            assert!((found.swing - swing).abs() < 1e-12, "{swing}");
            assert!(
                (found.twist - twist).abs() < 1e-10,
                "{twist}: {}",
                found.twist
            );
        }
    }

    #[test]
    fn slopes_and_curvatures_are_derivatives_also_near_half_a_turn() {
        let random = &mut Random::new(2);
        let axis = DVec3::new(0.48, -0.6, 0.64);
        let step = 1e-4;
        for angle in [0.2, 1.0, 2.5, 3.1] {
            let q = rotation_exp(random.vector(1.0).normalize() * angle);
            let now = SwingTwist::new(q, axis);
            let at = |e: DVec3| {
                let there = SwingTwist::new(rotation_exp(e) * q, axis);
                [there.swing, there.twist]
            };
            let (slopes, curvatures) = (
                [now.swing_slope(), now.twist_slope()],
                [now.swing_curvature(), now.twist_curvature()],
            );
            for e in [DVec3::X, DVec3::Y, DVec3::new(0.6, -0.3, 0.5)] {
                let (behind, here, ahead) = (at(-step * e), at(DVec3::ZERO), at(step * e));
                for k in 0..2 {
                    let first = (ahead[k] - behind[k]) / (2.0 * step);
                    let second = (ahead[k] - 2.0 * here[k] + behind[k]) / (step * step);
                    let (slope, bend) = (slopes[k].dot(e), e.dot(curvatures[k] * e));
                    // Truncation grows with the third and fourth derivatives, as 1/cos³(β/2).
                    let size = 1.0
                        + curvatures[k]
                            .to_cols_array()
                            .iter()
                            .fold(0.0, |a: f64, c| a.max(c.abs()))
                            .powi(3);
                    assert!(
                        (slope - first).abs() < 1e-7 * size,
                        "{angle} {k}: {slope} {first}"
                    );
                    assert!(
                        (bend - second).abs() < 1e-6 * size,
                        "{angle} {k}: {bend} {second}"
                    );
                }
            }
        }
    }
}
