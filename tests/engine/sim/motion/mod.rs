//! How tissue moves (method §5): swings, spins and slides as their physics says, at any rate of frames.

mod frames;
mod holding;
mod joints;
mod order;
mod ringing;
mod slope;

use faer::linalg::solvers::Solve;
use std::f64::consts::PI;
use std::sync::Arc;
use supple::Result;
use supple::glam::DVec3;
use supple::model::{Avatar, InertialTarget, State};
use supple::potential::{CpuPotential, HessianForm, Potential, StepStart, TissueFactors};
use supple::sim::{Settings, Simulation};

const CONVERGED: supple::sim::SolverMode = supple::sim::SolverMode::Converged {
    tolerance: 1e-10,
    max_iterations: 100,
};

fn simulation(avatar: &Avatar, settings: Settings) -> Simulation<CpuPotential> {
    let potential = CpuPotential::new(Arc::new(avatar.clone()), 1).unwrap();
    Simulation::new(avatar, potential, settings).unwrap()
}

/// The first mode of tissue on bones that are held.
struct Mode {
    /// Hz.
    frequency: f64,
    /// φ of every handle, the largest 1.
    shape: Vec<DVec3>,
    /// M times that, kg.
    momentum: Vec<DVec3>,
}

impl Mode {
    /// K v = ω² M v by inverse iteration: K is the Hessian of an endless step, M what a short one adds times h².
    fn first(avatar: &Avatar) -> Result<Self> {
        let rest = avatar.rest_state();
        let mut potential = CpuPotential::new(Arc::new(avatar.clone()), 1)?;
        let first = 6 * rest.frames.len();
        let size = avatar.space().dofs() - first;
        let mut factors = TissueFactors::default();
        factors.damping = 0.0;
        let mut hessian = |time_step: f64| -> Result<faer::Mat<f64>> {
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
            Ok(faer::Mat::from_fn(size, size, |i, j| {
                dense[first + i][first + j]
            }))
        };
        let stiffness = hessian(1e6)?;
        let mass = hessian(1.0)? - &stiffness;
        let factor = stiffness.llt(faer::Side::Lower).unwrap();
        let mut v = faer::Mat::from_fn(size, 1, |i, _| 1.0 + (i % 3) as f64);
        let mut rate = 0.0;
        for _ in 0..200 {
            let next = factor.solve(&mass * &v);
            rate = 1.0 / (0..size).map(|i| next[(i, 0)].abs()).fold(0.0, f64::max);
            v = next * rate;
        }
        let momentum = &mass * &v;
        let blocks = |m: &faer::Mat<f64>| -> Vec<DVec3> {
            (0..size / 3)
                .map(|h| DVec3::from_array(std::array::from_fn(|k| m[(3 * h + k, 0)])))
                .collect()
        };
        Ok(Self {
            frequency: rate.sqrt() / (2.0 * PI),
            shape: blocks(&v),
            momentum: blocks(&momentum),
        })
    }

    /// How much of it is in a state.
    fn amplitude(&self, state: &State) -> f64 {
        let dot = |a: &[DVec3], b: &[DVec3]| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum::<f64>();
        dot(&self.momentum, &state.handles) / dot(&self.momentum, &self.shape)
    }
}

/// The damped swing a e^(−σ t) cos(ω t − ψ) that is nearest to `samples` (time, value): σ and ω.
fn fit(samples: &[(f64, f64)], omega: f64) -> (f64, f64) {
    // The least squares of the amplitudes of cos and sin for given σ and ω.
    let error = |(sigma, omega): (f64, f64)| {
        let (mut a, mut b) = ([0.0; 3], [0.0; 2]);
        for &(t, y) in samples {
            let (s, c) = (omega * t).sin_cos();
            let (c, s) = ((-sigma * t).exp() * c, (-sigma * t).exp() * s);
            a = [a[0] + c * c, a[1] + c * s, a[2] + s * s];
            b = [b[0] + c * y, b[1] + s * y];
        }
        let determinant = a[0] * a[2] - a[1] * a[1];
        let x = (a[2] * b[0] - a[1] * b[1]) / determinant;
        let y = (a[0] * b[1] - a[1] * b[0]) / determinant;
        // |f|² − what the fit takes of it.
        samples.iter().map(|(_, f)| f * f).sum::<f64>() - x * b[0] - y * b[1]
    };
    let mut best = (0.3 * omega, omega);
    let mut reach = (0.3 * omega, 0.4 * omega);
    for _ in 0..14 {
        let around = (-4..=4).flat_map(|i| (-4..=4).map(move |j| (f64::from(i), f64::from(j))));
        let center = best;
        for (i, j) in around {
            let tried = (center.0 + i * reach.0 / 4.0, center.1 + j * reach.1 / 4.0);
            if error(tried) < error(best) {
                best = tried;
            }
        }
        reach = (0.5 * reach.0, 0.5 * reach.1);
    }
    best
}
