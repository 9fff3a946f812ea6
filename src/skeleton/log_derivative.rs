//! The derivative of the logarithm on SO(3).

use crate::math::skew;
use glam::{DMat3, DVec3};

/// J_l⁻¹(r) with log(exp(\[ε\]) exp(\[r\])) = r + J_l⁻¹(r) ε + O(ε²).
///
/// J_l⁻¹(r) = I − ½\[r\]× + (1/θ² − (1 + cos θ)/(2θ sin θ)) \[r\]×², θ = |r| (Solà et al. 2018, eq. 146).
pub fn inverse_left_jacobian(r: DVec3) -> DMat3 {
    let square = r.length_squared();
    let angle = square.sqrt();
    let factor = if angle < 0.1 {
        // The closed form cancels near 0; its series is 1/12 + θ²/720 + θ⁴/30240 + θ⁶/1209600 + …
        1.0 / 12.0 + square * (1.0 / 720.0 + square * (1.0 / 30_240.0 + square / 1_209_600.0))
    } else {
        // (1 + cos θ)/sin θ = cot(θ/2), which stays finite up to π.
        (1.0 - 0.5 * angle / (0.5 * angle).tan()) / square
    };
    let cross = skew(r);
    DMat3::IDENTITY - cross * 0.5 + cross * cross * factor
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
}
