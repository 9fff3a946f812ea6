//! The first mode of tissue on bones that are held, and the damped swing that samples show.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use glam::DVec3;
use std::f64::consts::TAU;
use std::sync::Arc;
use supple::model::{Avatar, InertialTarget, State};
use supple::potential::{CpuPotential, HessianForm, Potential, StepStart, TissueFactors};
use supple::{Error, Result};

/// The first mode.
pub(super) struct Mode {
    /// Hz.
    pub frequency: f64,
    /// φ of every handle, the largest component 1.
    pub shape: Vec<DVec3>,
    /// M times that, kg.
    pub momentum: Vec<DVec3>,
}

impl Mode {
    /// K v = ω² M v by inverse iteration. K is the Hessian of a step so long that inertia is nothing, and M is what one of
    /// a second adds to it.
    pub fn first(avatar: &Avatar) -> Result<Self> {
        const ITERATIONS: usize = 200;
        let rest = avatar.rest_state();
        let mut potential = CpuPotential::new(Arc::new(avatar.clone()), 1)?;
        let bones = 6 * rest.frames.len();
        let size = avatar.space().dofs() - bones;
        let mut factors = TissueFactors::default();
        factors.damping = 0.0;
        let mut hessian = |time_step: f64| -> Result<Mat<f64>> {
            let start = StepStart {
                time_step,
                inertia: InertialTarget::backward_euler(&rest, time_step),
                current: &rest,
                colliders: &[],
                tissue_gravity: DVec3::ZERO,
                slip_speed: 1e-3,
                geometric_contact: false,
                factors,
                pose_offsets: &[],
                prescribed: &[],
            };
            pollster::block_on(potential.begin_step(&[start], &[true]))?;
            let dense = potential.dense_hessian(0, &rest, HessianForm::Solver)?;
            Ok(Mat::from_fn(size, size, |i, k| dense[bones + i][bones + k]))
        };
        let stiffness = hessian(1e6)?;
        let mass = hessian(1.0)? - &stiffness;
        let factor = (stiffness.llt(Side::Lower))
            .map_err(|_| Error::invalid("avatar", "its tissue is not held by its bones"))?;
        let mut v = Mat::from_fn(size, 1, |i, _| 1.0 + (i % 3) as f64);
        let mut square = 0.0;
        for _ in 0..ITERATIONS {
            let next = factor.solve(&mass * &v);
            square = 1.0 / (0..size).map(|i| next[(i, 0)].abs()).fold(0.0, f64::max);
            v = next * square;
        }
        let blocks = |m: &Mat<f64>| -> Vec<DVec3> {
            let block = |h| DVec3::from_array(std::array::from_fn(|k| m[(3 * h + k, 0)]));
            (0..size / 3).map(block).collect()
        };
        Ok(Self {
            frequency: square.sqrt() / TAU,
            shape: blocks(&v),
            momentum: blocks(&(&mass * &v)),
        })
    }

    /// How much of it is in a state.
    pub fn amplitude(&self, state: &State) -> f64 {
        let dot = |a: &[DVec3]| -> f64 {
            let pairs = self.momentum.iter().zip(a);
            pairs.map(|(p, x)| p.dot(*x)).sum()
        };
        dot(&state.handles) / dot(&self.shape)
    }
}

/// σ and ω, 1/s, of the damped swing e^(−σt) (x cos ωt + y sin ωt) that is nearest to `samples` (s, value), found around
/// `omega` by a search in σ and ω with x and y by least squares.
pub(super) fn damped_swing(samples: &[(f64, f64)], omega: f64) -> (f64, f64) {
    let error = |(sigma, omega): (f64, f64)| {
        let (mut a, mut b) = ([0.0; 3], [0.0; 2]);
        for &(t, value) in samples {
            let (sine, cosine) = (omega * t).sin_cos();
            let decay = (-sigma * t).exp();
            let (c, s) = (decay * cosine, decay * sine);
            a = [a[0] + c * c, a[1] + c * s, a[2] + s * s];
            b = [b[0] + c * value, b[1] + s * value];
        }
        let determinant = a[0] * a[2] - a[1] * a[1];
        // What the fit leaves of |value|², but for a constant: −bᵀ A⁻¹ b.
        -(a[2] * b[0] * b[0] - 2.0 * a[1] * b[0] * b[1] + a[0] * b[1] * b[1]) / determinant
    };
    let mut best = (0.3 * omega, omega);
    let mut reach = (0.3 * omega, 0.4 * omega);
    for _ in 0..14 {
        let centre = best;
        for i in -4..=4 {
            for k in -4..=4 {
                let tried = (
                    centre.0 + 0.25 * f64::from(i) * reach.0,
                    centre.1 + 0.25 * f64::from(k) * reach.1,
                );
                if error(tried) < error(best) {
                    best = tried;
                }
            }
        }
        reach = (0.5 * reach.0, 0.5 * reach.1);
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damped_swing_is_found_in_its_samples() {
        let (sigma, omega) = (3.0, 24.0);
        let swing = |t: f64| (-sigma * t).exp() * (omega * t - 0.4).cos();
        let samples: Vec<(f64, f64)> = (0..100)
            .map(|k| 0.0123 * f64::from(k))
            .map(|t| (t, swing(t)))
            .collect();
        let (found, pitch) = damped_swing(&samples, 25.0);
        assert!((found - sigma).abs() < 1e-2, "{found}");
        assert!((pitch - omega).abs() < 1e-2, "{pitch}");
    }
}
