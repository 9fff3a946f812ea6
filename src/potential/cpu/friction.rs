//! Lagged, smoothed Coulomb friction (Li et al. 2020, Incremental Potential Contact, §4): the contacts of
//! qⁿ, each with its normal force λ, slide on their tangent planes under
//!
//! ```text
//! E = Σ μ λ f₀(|u_T|)      f₀(y) = y²/ε − y³/(3 ε²) below ε = ε_v h, y − ε/3 above
//! u = d − (ΔR a + Δc)      u_T = u − n (n · u)      n = R nⁿ, a and nⁿ in the collider's own axes
//! ```
//!
//! d is the vertex's displacement since qⁿ, (ΔR, Δc) that of the frame that the collider is fixed to, a
//! where the vertex was in that frame. The list, λ and the tangent plane (seen from the collider) do not
//! change in a step: E is a true potential, and turns with the pair.

use super::contact::ContactRow;
use super::displacement::FrameMotion;
use glam::DVec3;

/// A contact of qⁿ with a rough collider.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lagged {
    /// The skin vertex.
    pub vertex: u32,
    /// Which collider.
    pub collider: u32,
    /// The frame that carries it.
    pub body: Option<u32>,
    /// a: where the vertex was at tⁿ in the collider's (or its body's) frame, m.
    pub anchor: DVec3,
    /// nⁿ, in the same axes: a unit vector.
    pub normal: DVec3,
    /// μ λ, N.
    pub limit: f64,
}

/// How a vertex has moved over a collider since tⁿ.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slip {
    /// u, m.
    pub displacement: DVec3,
    /// n, a unit vector.
    pub normal: DVec3,
}

impl Slip {
    /// u_T, m.
    pub fn tangential(&self) -> DVec3 {
        self.displacement - self.normal * self.normal.dot(self.displacement)
    }

    /// |u_T|, m.
    pub fn length(&self) -> f64 {
        self.tangential().length()
    }
}

/// ΔR a + Δc: how the collider's material at the vertex has moved, m.
pub fn carried(lagged: &Lagged, ground: &FrameMotion) -> DVec3 {
    ground.rotation_change * lagged.anchor + ground.translation_change
}

/// f₀(y) − f₀(base), m; ε = `smoothing`.
pub fn smoothed_difference(base: f64, y: f64, smoothing: f64) -> f64 {
    let (b, s) = (base.min(smoothing), y.min(smoothing));
    let mean_slope = (s + b) / smoothing - (s * s + s * b + b * b) / (3.0 * smoothing * smoothing);
    (s - b) * mean_slope + (y - s) - (base - b)
}

/// (f₀′/y, f₀″), 1/m.
pub fn smoothed_slopes(y: f64, smoothing: f64) -> (f64, f64) {
    if y >= smoothing {
        return (y.recip(), 0.0);
    }
    let per_length = smoothing.recip();
    (
        (2.0 - y * per_length) * per_length,
        2.0 * (1.0 - y * per_length) * per_length,
    )
}

/// |f(u) − f(u_b) − H(u_b) (u − u_b)| of a unit limit, from the slip u_b = `base` to u = `slip`, with
/// f = f₀′(|u_T|) u_T/|u_T|: by how much friction is other than its rows at the base say.
pub fn unforeseen(base: &Slip, slip: &Slip, smoothing: f64) -> f64 {
    let (from, to) = (base.tangential(), slip.tangential());
    let (over_length, curvature) = smoothed_slopes(from.length(), smoothing);
    let along = from.try_normalize().unwrap_or(DVec3::ZERO);
    let change = to - from;
    let modelled = change * over_length + along * (along.dot(change) * (curvature - over_length));
    let force = |u: DVec3| u * smoothed_slopes(u.length(), smoothing).0;
    (force(to) - force(from) - modelled).length()
}

/// Friction as two rows: along the slip with f = μ λ f₀′ and k = μ λ f₀″, and across it with k = μ λ f₀′/y.
pub fn rows(lagged: &Lagged, slip: &Slip, smoothing: f64) -> [ContactRow; 2] {
    let tangential = slip.tangential();
    let y = tangential.length();
    let (over_length, curvature) = smoothed_slopes(y, smoothing);
    // At rest every tangent is as good.
    let along = if y > 0.0 {
        tangential / y
    } else {
        slip.normal.any_orthonormal_vector()
    };
    let row = |direction, force, stiffness| ContactRow {
        vertex: lagged.vertex,
        body: lagged.body,
        direction,
        force: lagged.limit * force,
        stiffness: lagged.limit * stiffness,
    };
    [
        row(along, over_length * y, curvature),
        row(slip.normal.cross(along), 0.0, over_length),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_differences_of_the_energy_on_both_sides_of_the_smoothing() {
        let (smoothing, step) = (1e-5, 1e-10);
        for y in [1e-7, 4e-6, 9.9e-6, 1.01e-5, 3e-4] {
            let (over_length, curvature) = smoothed_slopes(y, smoothing);
            let slope = smoothed_difference(y - step, y + step, smoothing) / (2.0 * step);
            assert!((over_length * y - slope).abs() < 1e-8, "{y}: {slope}");
            let slope = |y: f64| smoothed_slopes(y, smoothing).0 * y;
            let bend = (slope(y + step) - slope(y - step)) / (2.0 * step);
            assert!((curvature - bend).abs() < 1e-4 / smoothing, "{y}: {bend}");
        }
        // Coulomb's law beyond: the slope is 1.
        let slope = smoothed_slopes(2.0 * smoothing, smoothing).0 * 2.0 * smoothing;
        assert!((slope - 1.0).abs() < 1e-15);
        let whole = smoothed_difference(0.0, 1.0, smoothing);
        assert!((whole - (1.0 - smoothing / 3.0)).abs() < 1e-12);
    }

    #[test]
    fn friction_opposes_the_slip_and_never_exceeds_its_limit() {
        let lagged = Lagged {
            vertex: 0,
            collider: 0,
            body: None,
            anchor: DVec3::ZERO,
            normal: DVec3::Z,
            limit: 2.0,
        };
        for y in [0.0, 1e-9, 3e-6, 1e-5, 1e-3] {
            let tangential = DVec3::new(0.6, -0.8, 0.0) * y;
            let slip = Slip {
                displacement: tangential + DVec3::Z * 0.1,
                normal: DVec3::Z,
            };
            let [along, across] = rows(&lagged, &slip, 1e-5);
            let push = -along.force * along.direction;
            assert!(push.length() <= lagged.limit * (1.0 + 1e-15));
            assert!(push.dot(tangential) <= 0.0 && push.cross(tangential).length() < 1e-15);
            assert!(
                (y < 9e-6) == (push.length() < 0.9999 * lagged.limit),
                "{y}: {push}"
            );
            assert_eq!(across.force, 0.0);
            assert!(along.stiffness >= 0.0 && across.stiffness >= along.stiffness);
            assert!(across.direction.dot(along.direction).abs() < 1e-15);
            assert!(along.direction.z.abs() + across.direction.z.abs() < 1e-15);
        }
    }
}
