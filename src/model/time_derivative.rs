//! BDF2 with steps of any length (method §5), and backward Euler, which is the same without history.
//!
//! ```text
//! q̇ⁿ⁺¹ = (qⁿ⁺¹ − q̃)/h̃,   q̃ = a₀ qⁿ − a₁ qⁿ⁻¹
//! a₀ = (1+r)²/(1+2r)   a₁ = r²/(1+2r)   h̃ = h (1+r)/(1+2r)      r = h/g, g the step before; r = 0 without one
//! ```
//!
//! Applied twice, to a place and then to its velocity, it says where a point without forces would be:
//! x̂ = Σ_{k=0..3} c_k x(qⁿ⁻ᵏ), and inertia is Σ m/(2h̃²) |x − x̂|². With n the step that ended at tⁿ:
//!
//! ```text
//! c₀ =  a₀ + h̃ a₀/h̃ₙ                  c₁ = −a₁ − h̃ a₀ a₀ₙ/h̃ₙ − h̃ a₁/h̃ₙ₋₁
//! c₂ =  h̃ a₀ a₁ₙ/h̃ₙ + h̃ a₁ a₀ₙ₋₁/h̃ₙ₋₁   c₃ = −h̃ a₁ a₁ₙ₋₁/h̃ₙ₋₁          Σ c = 1
//! ```
//!
//! Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, §III.5 (variable steps; stable up to r = 1 + √2).

use super::{Frame, State};
use crate::math::singular_values;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// How a step differentiates.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimeDerivative {
    /// a₀ and a₁.
    pub weights: [f64; 2],
    /// h̃, s.
    pub step: f64,
}

impl TimeDerivative {
    /// Of a step of `time_step` (s) that follows on one of `last_step`.
    pub fn bdf2(time_step: f64, last_step: f64) -> Self {
        let r = time_step / last_step;
        let divisor = 1.0 + 2.0 * r;
        Self {
            weights: [(1.0 + r) * (1.0 + r) / divisor, r * r / divisor],
            step: time_step * (1.0 + r) / divisor,
        }
    }

    /// Of a step of `time_step` (s) by itself.
    pub fn backward_euler(time_step: f64) -> Self {
        Self {
            weights: [1.0, 0.0],
            step: time_step,
        }
    }

    /// c₁, c₂ and c₃ of a step, after those of the two `before`, the last one first.
    pub fn inertial_weights(&self, before: &[Self; 2]) -> [f64; 3] {
        let [a0, a1] = self.weights;
        let [last, earlier] = before.map(|of| (of.weights, self.step / of.step));
        let ([a0n, a1n], ratio) = last;
        let ([a0m, a1m], ratio_before) = earlier;
        [
            -a1 - ratio * a0 * a0n - ratio_before * a1,
            ratio * a0 * a1n + ratio_before * a1 * a0m,
            -ratio_before * a1 * a1m,
        ]
    }

    /// Whether both numbers and the step are usable.
    pub(crate) fn is_valid(&self) -> bool {
        self.weights.iter().all(|a| a.is_finite()) && self.step > 0.0 && self.step.is_finite()
    }
}

/// Where a step's inertia draws to, x̂ − x(qⁿ) = Σ_{k≥1} c_k (x(qⁿ⁻ᵏ) − x(qⁿ)), and how it differentiates.
#[derive(Clone, Copy, Debug)]
pub struct InertialTarget<'a> {
    /// qⁿ⁻¹ and those before it, as many as are read; at most three.
    pub past: &'a [State],
    /// c₁ to c₃.
    pub weights: [f64; 3],
    /// a₁: what has a velocity in this step's sense is drawn to q̃ = qⁿ + a₁ (qⁿ − qⁿ⁻¹).
    pub drift: f64,
    /// h̃, s.
    pub step: f64,
    /// The part of the root's acceleration that is not felt.
    pub share: Option<InertiaShare>,
}

impl<'a> InertialTarget<'a> {
    /// That of backward Euler where qⁿ was reached from `previous` in a step of the same length.
    pub fn backward_euler(previous: &'a State, time_step: f64) -> Self {
        Self {
            past: std::slice::from_ref(previous),
            weights: [-1.0, 0.0, 0.0],
            drift: 0.0,
            step: time_step,
            share: None,
        }
    }

    /// (c_k, qⁿ⁻ᵏ) of those that count.
    pub fn terms(&self) -> impl Iterator<Item = (f64, &'a State)> + Clone + use<'a> {
        let weights = self.weights.into_iter().zip(self.past);
        weights.filter(|(weight, _)| *weight != 0.0)
    }

    /// Σ_{k≥1} c_k (A_j(qⁿ⁻ᵏ) − A_j(qⁿ)) of a frame A = \[R | c\] that stands at `current`, and what it is carried along.
    pub fn frame(&self, j: usize, current: &Frame) -> (DMat3, DVec3) {
        let mut sum = (DMat3::ZERO, DVec3::ZERO);
        for (weight, past) in self.terms() {
            let frame = &past.frames[j];
            sum.0 += (frame.rotation - current.rotation) * weight;
            sum.1 += (frame.position - current.position) * weight;
        }
        if let Some(share) = &self.share {
            let (turn, shift) = share.of(current);
            sum.0 += turn;
            sum.1 += shift;
        }
        sum
    }

    /// a₁ (φⁿ − φⁿ⁻¹) of handle `h`, which stands at `current`, m.
    pub fn handle_drift(&self, h: usize, current: DVec3) -> DVec3 {
        match self.past {
            [previous, ..] if self.drift != 0.0 => (current - previous.handles[h]) * self.drift,
            _ => DVec3::ZERO,
        }
    }

    /// Moves `state`, which is qⁿ, to where inertia alone would have it: φ̂ = Σ c_k φⁿ⁻ᵏ, ĉ likewise, and the rotations
    /// nearest to Σ c_k Rⁿ⁻ᵏ.
    pub fn predict(&self, state: &mut State) {
        for (j, frame) in state.frames.iter_mut().enumerate() {
            let (rotation, position) = self.frame(j, frame);
            if rotation != DMat3::ZERO {
                frame.rotation = nearest_rotation(frame.rotation + rotation);
            }
            frame.position += position;
        }
        for (h, handle) in state.handles.iter_mut().enumerate() {
            let current = *handle;
            for (weight, past) in self.terms() {
                *handle += (past.handles[h] - current) * weight;
            }
        }
    }
}

/// The share ι of the root's acceleration that all else ignores. With A_r = \[R_r | c_r\] and
/// D = A_rⁿ⁺¹ − Σ_{k≥0} c_k A_rⁿ⁻ᵏ, what stands at x in the world is drawn to x̂ + ι D \[R_rⁿᵀ (x − c_rⁿ); 1\], as if it moved with
/// the root, and a frame to Â + ι D \[R_rⁿᵀ R, R_rⁿᵀ (c − c_rⁿ)\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InertiaShare {
    /// ι D R_rⁿᵀ of the rotations.
    turn: DMat3,
    /// ι D of the position, m.
    shift: DVec3,
    /// c_rⁿ, m.
    root: DVec3,
}

impl InertiaShare {
    /// Where the root goes to `end` in a step with this `target`: a share of at least `share`, and so much more that nothing
    /// in `state` is left behind by more than `longest`, m; none where that is nothing.
    pub(crate) fn new(
        target: &InertialTarget<'_>,
        state: &State,
        end: &Frame,
        share: f64,
        longest: f64,
    ) -> Option<Self> {
        let root = state.frames.first()?;
        let (turn, shift) = target.frame(0, root);
        let all = Self {
            turn: (end.rotation - root.rotation - turn) * root.rotation.transpose(),
            shift: end.position - root.position - shift,
            root: root.position,
        };
        let moved = state.frames.iter().map(|frame| all.of(frame).1.length());
        let farthest = moved.fold(0.0, f64::max);
        let share = if farthest > longest {
            share.max(1.0 - longest / farthest)
        } else {
            share
        };
        (share > 0.0 && farthest > 0.0).then(|| Self {
            turn: all.turn * share,
            shift: all.shift * share,
            ..all
        })
    }

    /// What a frame that stands at `current` is carried along.
    fn of(&self, current: &Frame) -> (DMat3, DVec3) {
        let arm = current.position - self.root;
        (self.turn * current.rotation, self.turn * arm + self.shift)
    }
}

/// The R of the polar decomposition, orthonormal to rounding.
fn nearest_rotation(m: DMat3) -> DMat3 {
    let parts = singular_values(m);
    let frame = Frame {
        rotation: parts.u * parts.v.transpose(),
        position: DVec3::ZERO,
    };
    frame.moved(DVec3::ZERO, DVec3::ZERO).rotation
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Random, rotation_exp};
    use crate::model::{History, Integrator};

    /// Times of the states before the present, and the history that steps of these lengths leave.
    fn irregular(q: impl Fn(f64) -> DVec3) -> (State, History) {
        let at = |t: f64| State {
            frames: vec![Frame::IDENTITY],
            handles: vec![q(t)],
            awake: Vec::new(),
        };
        let steps = [0.004, 0.007, 0.005, 0.009];
        let mut time = -steps.iter().sum::<f64>();
        let mut history = History::at_rest(&at(time));
        for h in steps {
            history.advance(&at(time), Integrator::Bdf2, h);
            time += h;
        }
        (at(0.0), history)
    }

    /// x̂ is exact for what moves evenly, and x̂ + h̃² ẍ for what is accelerated evenly: second order.
    #[test]
    fn it_is_exact_to_second_order_at_any_steps() {
        let (x0, v, a) = (
            DVec3::X,
            DVec3::new(0.3, -2.0, 1.0),
            DVec3::new(-5.0, 3.0, 9.0),
        );
        let q = |t: f64| x0 + v * t + 0.5 * a * t * t;
        let (now, history) = irregular(q);
        let h = 0.012;
        let target = history.target(Integrator::Bdf2, h);
        let mut predicted = now.clone();
        target.predict(&mut predicted);
        let wanted = q(h) - target.step * target.step * a;
        let error = predicted.handles[0].distance(wanted);
        assert!(error < 1e-14, "{error:e}");
        // Backward Euler has no memory of accelerations: it is off by half of one step's.
        let target = history.target(Integrator::BackwardEuler, h);
        let mut predicted = now.clone();
        target.predict(&mut predicted);
        assert!(predicted.handles[0].distance(q(h) - h * h * a) > 1e-5);
    }

    /// Of constant steps: 8/3, −22/9, 8/9 and −1/9 of the four states, h̃ = 2h/3.
    #[test]
    fn constant_steps_have_the_known_weights() {
        let derivative = TimeDerivative::bdf2(0.01, 0.01);
        let weights = derivative.inertial_weights(&[derivative; 2]);
        let known = [-22.0 / 9.0, 8.0 / 9.0, -1.0 / 9.0];
        for (weight, known) in weights.iter().zip(known) {
            assert!((weight - known).abs() < 1e-14, "{weights:?}");
        }
        assert!((derivative.step - 0.02 / 3.0).abs() < 1e-16);
    }

    #[test]
    fn a_velocity_is_kept_by_the_first_step() {
        let random = &mut Random::new(3);
        let state = State {
            frames: vec![Frame::IDENTITY.moved(random.vector(1.0), random.vector(2.0))],
            handles: vec![random.vector(1.0)],
            awake: Vec::new(),
        };
        let (velocity, spin) = (random.vector(1.0), random.vector(3.0));
        for integrator in [Integrator::Bdf2, Integrator::BackwardEuler] {
            let mut history = History::at_rest(&state);
            assert!(!history.starts_moving(&state));
            history.set_velocity(0, &state.frames[0], velocity, spin);
            assert!(history.starts_moving(&state));
            let mut predicted = state.clone();
            history.target(integrator, 0.01).predict(&mut predicted);
            let moved = predicted.frames[0].position - state.frames[0].position;
            assert!(moved.distance(0.01 * velocity) < 1e-12);
            // Of a step of angle α the chord's direction is α − α³/3, or nearer.
            let turned = rotation_exp(0.01 * spin) * state.frames[0].rotation;
            let off = (predicted.frames[0].rotation - turned).to_cols_array();
            let bound = (0.01 * spin.length()).powi(3);
            assert!(off.iter().all(|x| x.abs() < bound), "{off:?}");
            assert_eq!(predicted.handles, state.handles);
        }
    }
}
