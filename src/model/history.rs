//! The states before qⁿ, from which a step takes its velocities.

use super::{Frame, InertialTarget, State, TimeDerivative};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// ε, s: how far back the states lie that say a velocity where none led to qⁿ. Short, so that the chord of a turn is its
/// tangent, and long enough for f64.
const INSTANT: f64 = 1e-4;

/// Which formula a step differentiates by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Integrator {
    /// Second order: tissue swings as its damping says, at any rate of frames.
    #[default]
    Bdf2,
    /// First order, the paper's: it damps whatever moves fast, by a ratio of about ωh/2.
    BackwardEuler,
}

/// qⁿ⁻¹, qⁿ⁻² and qⁿ⁻³, and how the steps between them differentiated.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct History {
    /// The last one first.
    states: [State; 3],
    /// How long before tⁿ each of them was, s.
    times: [f64; 3],
    /// Of the step that ended at tⁿ, and of the one before.
    derivatives: [TimeDerivative; 2],
    /// Whether a step or a motion led to qⁿ: else the states say no more than a velocity.
    continued: bool,
}

impl Clone for History {
    fn clone(&self) -> Self {
        Self {
            states: self.states.clone(),
            times: self.times,
            derivatives: self.derivatives,
            continued: self.continued,
        }
    }

    /// In the memory that is there, as a step needs it.
    fn clone_from(&mut self, other: &Self) {
        for (state, of) in self.states.iter_mut().zip(&other.states) {
            state.clone_from(of);
        }
        self.times = other.times;
        self.derivatives = other.derivatives;
        self.continued = other.continued;
    }
}

impl History {
    /// Of an instance that rests at `state`.
    pub fn at_rest(state: &State) -> Self {
        Self {
            states: std::array::from_fn(|_| state.clone()),
            times: [INSTANT, 2.0 * INSTANT, 3.0 * INSTANT],
            derivatives: [TimeDerivative::backward_euler(INSTANT); 2],
            continued: false,
        }
    }

    /// Forgets what was: it rests at `state`.
    pub fn rest(&mut self, state: &State) {
        self.instant();
        self.states.iter_mut().for_each(|s| s.clone_from(state));
    }

    /// The states that follow say a velocity.
    fn instant(&mut self) {
        self.times = [INSTANT, 2.0 * INSTANT, 3.0 * INSTANT];
        self.derivatives = [TimeDerivative::backward_euler(INSTANT); 2];
        self.continued = false;
    }

    /// From now on `state` has the velocity with which it would be reached from `previous` in `time_step`, s.
    pub fn set_previous(&mut self, previous: &State, state: &State, time_step: f64) {
        self.instant();
        for (past, time) in self.states.iter_mut().zip(self.times) {
            past.clone_from(previous);
            past.stretch_from(state, time / time_step);
        }
    }

    /// From now on frame `j`, which is at `frame`, moves with `velocity` (m/s, of its origin) and `angular_velocity`
    /// (rad/s).
    pub fn set_velocity(&mut self, j: usize, frame: &Frame, velocity: DVec3, spin: DVec3) {
        for (past, time) in self.states.iter_mut().zip(self.times) {
            past.frames[j] = frame.moved(-velocity * time, -spin * time);
        }
    }

    /// From now on `past` are the states one, two and three steps of `time_step` (s) ago, as a clip knows them: velocities are
    /// as exact as the steps that follow.
    pub fn set_motion(&mut self, past: [State; 3], time_step: f64) {
        self.states = past;
        self.times = [time_step, 2.0 * time_step, 3.0 * time_step];
        self.derivatives = [TimeDerivative::bdf2(time_step, time_step); 2];
        self.continued = true;
    }

    /// qⁿ⁻¹: that of the last step, or of an instant ago.
    pub fn previous(&self) -> &State {
        &self.states[0]
    }

    /// How long before tⁿ [`History::previous`] was, s.
    pub fn last_step(&self) -> f64 {
        self.times[0]
    }

    /// All of them, the last one first.
    pub(crate) fn states(&self) -> &[State; 3] {
        &self.states
    }

    /// All of them, the last one first.
    pub(crate) fn states_mut(&mut self) -> &mut [State; 3] {
        &mut self.states
    }

    /// Whether a step led to qⁿ.
    pub(crate) fn is_continued(&self) -> bool {
        self.continued
    }

    /// Whether it starts with a velocity that no step led to: the first frame then takes shorter steps.
    pub(crate) fn starts_moving(&self, state: &State) -> bool {
        !self.continued && self.states[0] != *state
    }

    /// How a step of `time_step` from here differentiates.
    fn derivative(&self, integrator: Integrator, time_step: f64) -> TimeDerivative {
        match integrator {
            Integrator::Bdf2 if self.continued => TimeDerivative::bdf2(time_step, self.times[0]),
            _ => TimeDerivative::backward_euler(time_step),
        }
    }

    /// What inertia draws to in a step of `time_step`, s.
    pub fn target(&self, integrator: Integrator, time_step: f64) -> InertialTarget<'_> {
        let derivative = self.derivative(integrator, time_step);
        let [_, drift] = derivative.weights;
        InertialTarget {
            past: &self.states,
            weights: derivative.inertial_weights(&self.derivatives),
            drift,
            step: derivative.step,
            share: None,
        }
    }

    /// What a point that ended at qⁿ has its velocity against: (x(qⁿ) − x̃)/h̃ of the step that led there, from qⁿ⁻¹.
    pub(crate) fn velocity(&self) -> InertialTarget<'_> {
        let [_, a1] = self.derivatives[0].weights;
        InertialTarget {
            past: &self.states[1..],
            weights: [-a1, 0.0, 0.0],
            drift: 0.0,
            step: self.derivatives[0].step,
            share: None,
        }
    }

    /// A step of `time_step` leads away from `state`, which is qⁿ no more.
    pub(crate) fn advance(&mut self, state: &State, integrator: Integrator, time_step: f64) {
        let derivative = self.derivative(integrator, time_step);
        self.derivatives = [derivative, self.derivatives[0]];
        let [last, earlier, _] = self.times;
        self.times = [time_step, last + time_step, earlier + time_step];
        self.continued = true;
        self.states.rotate_right(1);
        self.states[0].clone_from(state);
    }

    /// Whether all numbers are usable.
    pub(crate) fn is_valid(&self) -> bool {
        let [a, b, c] = self.times;
        let rising = 0.0 < a && a < b && b < c && c.is_finite();
        rising && self.derivatives.iter().all(TimeDerivative::is_valid)
    }
}
