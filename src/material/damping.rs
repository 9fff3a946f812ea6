//! How long tissue rings: damping ratio ζ and damping time β from the one number that a user turns.
//!
//! ```text
//! ζ = 10^(−1.5 b)      β = ζ/(π f)
//! ```
//!
//! With stiffness-proportional damping a mode of f Hz has ζ = π f β. On an even scale of bounce b the number of swings grows by
//! even factors: of half swings above a tenth of the first there are 1, 5 and 24 at b = 0, 0.5 and 1.

/// The bounce that tissue is baked with unless a recipe says another.
pub const DEFAULT_BOUNCE: f64 = 0.5;

/// ζ of a bounce of 0 (critically damped) to 1 (0.032).
pub fn damping_ratio(bounce: f64) -> f64 {
    10f64.powf(-1.5 * bounce)
}

/// β, s, with which tissue whose first mode has `frequency`, Hz, has the `bounce`.
pub fn damping_time(bounce: f64, frequency: f64) -> f64 {
    damping_ratio(bounce) / (std::f64::consts::PI * frequency)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn bounce_runs_from_critical_damping_to_a_thirtieth_of_it() {
        assert_eq!(damping_ratio(0.0), 1.0);
        assert_relative_eq!(damping_ratio(DEFAULT_BOUNCE), 0.1778, epsilon = 1e-4);
        assert_relative_eq!(damping_ratio(1.0), 0.0316, epsilon = 1e-4);
        // ζ = ω β/2 = π f β
        let zeta = std::f64::consts::PI * 4.0 * damping_time(0.3, 4.0);
        assert_relative_eq!(zeta, damping_ratio(0.3), max_relative = 1e-14);
        // An oscillator's amplitude falls by exp(−π ζ/√(1 − ζ²)) from one half swing to the next.
        let half_swings = |bounce: f64| {
            let zeta = damping_ratio(bounce);
            10f64.ln() * (1.0 - zeta * zeta).sqrt() / (std::f64::consts::PI * zeta)
        };
        assert_eq!(half_swings(0.5).floor(), 4.0);
        assert_eq!(half_swings(1.0).round(), 23.0);
    }
}
