//! A damper of a residual, through the operator of the step.

use crate::model::{Frame, InertialTarget};
use glam::DVec3;

/// What a damper adds to a spring, ½ k |r|²: ½ d/h̃ |r − r̃|², r̃ = a₀ rⁿ − a₁ rⁿ⁻¹, so that its force is −d ṙ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Damper {
    /// d/h̃.
    rate: f64,
    /// r̃.
    start: DVec3,
}

impl Damper {
    /// Nothing.
    pub const NONE: Self = Self {
        rate: 0.0,
        start: DVec3::ZERO,
    };

    /// One of `damping` d on what `residual` says of frames, in a step that starts from `current`.
    pub fn new(
        damping: f64,
        current: &[Frame],
        inertia: &InertialTarget<'_>,
        residual: impl Fn(&[Frame]) -> DVec3,
    ) -> Self {
        if damping == 0.0 {
            return Self::NONE;
        }
        let mut start = residual(current);
        if let ([before, ..], true) = (inertia.past, inertia.drift != 0.0) {
            start += inertia.drift * (start - residual(&before.frames));
        }
        Self {
            rate: damping / inertia.step,
            start,
        }
    }

    /// ∂E/∂r with a spring of stiffness `k`.
    pub fn slope(&self, k: f64, r: DVec3) -> DVec3 {
        k * r + self.rate * (r - self.start)
    }

    /// ∂²E/∂r² with a spring of stiffness `k`.
    pub fn stiffness(&self, k: f64) -> f64 {
        k + self.rate
    }

    /// E(r) − E(r₀) with a spring of stiffness `k`: half the step times the sum of the slopes at both ends.
    pub fn difference(&self, k: f64, r0: DVec3, r: DVec3) -> f64 {
        0.5 * (r - r0).dot(self.slope(k, r) + self.slope(k, r0))
    }
}
