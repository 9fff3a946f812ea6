//! The derivative of the logarithm on SO(3).

use crate::math::skew;
use glam::{DMat3, DVec3};

/// J_l⁻¹(r) with log(exp(\[ε\]) exp(\[r\])) = r + J_l⁻¹(r) ε + O(ε²).
///
/// J_l⁻¹(r) = I − ½\[r\]× + (1/θ² − (1 + cos θ)/(2θ sin θ)) \[r\]×², θ = |r| (Solà et al. 2018, eq. 146).
pub fn inverse_left_jacobian(r: DVec3) -> DMat3 {
    let (factor, _) = factor(r);
    let cross = skew(r);
    DMat3::IDENTITY - cross * 0.5 + cross * cross * factor
}

/// The symmetric C with f · r″ = εᵀCε at t = 0, where r(t) = log(exp(t\[ε\]) exp(\[r\])).
///
/// r′ = J_l⁻¹(r) ε = u, so r″ = (∂J_l⁻¹/∂r · u) ε: with γ the factor of \[r\]×² in J_l⁻¹,
/// f · r″ = uᵀ(½\[f\]× + (γ′/θ) r (\[r\]×²f)ᵀ − γ(\[f\]×\[r\]× + \[f × r\]×)) ε.
pub fn log_curvature(r: DVec3, f: DVec3) -> DMat3 {
    let (factor, slope) = factor(r);
    let (cross, force) = (skew(r), skew(f));
    let along = slope * (cross * cross * f);
    let outer = DMat3::from_cols(r * along.x, r * along.y, r * along.z);
    let turned = (force * cross + skew(f.cross(r))) * factor;
    let c = inverse_left_jacobian(r).transpose() * (force * 0.5 + outer - turned);
    (c + c.transpose()) * 0.5
}

/// γ(θ) = 1/θ² − cot(θ/2)/(2θ), and γ′(θ)/θ.
fn factor(r: DVec3) -> (f64, f64) {
    let square = r.length_squared();
    let angle = square.sqrt();
    if angle < 0.1 {
        // The closed form cancels near 0; its series is 1/12 + θ²/720 + θ⁴/30240 + θ⁶/1209600 + …
        let terms = [1.0 / 12.0, 1.0 / 720.0, 1.0 / 30_240.0, 1.0 / 1_209_600.0];
        let [a, b, c, d] = terms;
        return (
            a + square * (b + square * (c + square * d)),
            2.0 * b + square * (4.0 * c + square * 6.0 * d),
        );
    }
    // (1 + cos θ)/sin θ = cot(θ/2), which stays finite up to π.
    let half = 0.5 * angle;
    let (cot, csc) = (half.tan().recip(), half.sin().recip());
    let slope = (-2.0 / square + 0.5 * cot / angle + 0.25 * csc * csc) / square;
    ((1.0 - half * cot) / square, slope)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{rotation_exp, rotation_log};

    #[test]
    fn it_is_the_derivative_of_the_logarithm() {
        let step = 1e-6;
        for angle in [0.0, 1e-6, 0.05, 0.0999, 0.1001, 1.0, 2.5, 3.1] {
            let r = DVec3::new(0.36, 0.48, -0.8) * angle;
            let jacobian = inverse_left_jacobian(r);
            for axis in DVec3::AXES {
                let log = |s: f64| rotation_log(rotation_exp(axis * s) * rotation_exp(r));
                let difference = (log(step) - log(-step)) / (2.0 * step);
                let error = (jacobian * axis - difference).length();
                assert!(error < 1e-8, "angle {angle}: {error:e}");
            }
            assert!((jacobian * r - r).length() < 1e-14);
        }
    }

    #[test]
    fn its_curvature_is_the_second_derivative() {
        let step = 1e-4;
        let f = DVec3::new(0.7, -1.1, 0.4);
        for angle in [0.0, 1e-6, 0.05, 0.0999, 0.1001, 1.0, 2.5, 3.1] {
            let r = DVec3::new(0.36, 0.48, -0.8) * angle;
            let curvature = log_curvature(r, f);
            for e in [DVec3::X, DVec3::Y, DVec3::new(0.6, -0.3, 0.5)] {
                let log = |s: f64| f.dot(rotation_log(rotation_exp(e * s) * rotation_exp(r)));
                let difference = (log(step) - 2.0 * log(0.0) + log(-step)) / (step * step);
                let error = (e.dot(curvature * e) - difference).abs();
                // Rounding ε/step² and truncation step² r⁗.
                assert!(error < 2e-7, "angle {angle}: {error:e}");
            }
        }
    }
}
