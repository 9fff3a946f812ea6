//! Equilibrium: where everything comes to rest that nothing moves.

use super::instance::{Instance, Pin};
use super::report::Timings;
use super::settings::{Settings, SolverMode};
use super::simulation::Simulation;
use crate::Result;
use crate::model::{History, Integrator, State};
use crate::potential::Potential;

/// A step so long that a swing of a few Hz keeps a hundredth of itself, s; what hangs limp still comes down in bounded steps.
pub(crate) const TIME_STEP: f64 = 1.0;

/// m.
const STILL: f64 = 1e-8;
const MOST_STEPS: usize = 50;

/// The settings of a step without inertia: each begins at rest and is solved to the end.
pub(crate) fn settings(of: &Settings) -> Settings {
    Settings {
        time_step: TIME_STEP,
        integrator: Integrator::BackwardEuler,
        largest_acceleration: f64::MAX,
        solver: SolverMode::Converged {
            tolerance: STILL,
            max_iterations: 100,
        },
        ..*of
    }
}

/// Steps until none moves anything any more.
pub(crate) struct Settling {
    steps: usize,
    /// How far anything moved in the last one, m.
    pub moved: f64,
}

impl Settling {
    /// Before the first.
    pub fn new() -> Self {
        Self {
            steps: 0,
            moved: f64::INFINITY,
        }
    }

    /// Whether there is another.
    pub fn goes_on(&mut self) -> bool {
        let goes_on = self.steps < MOST_STEPS && self.moved > STILL;
        if goes_on {
            self.steps += 1;
            self.moved = 0.0;
        }
        goes_on
    }

    /// Takes an instance in that has made the step, and puts it at rest.
    pub fn take(&mut self, instance: &mut Instance) {
        let moved = moved(instance.history.previous(), &instance.state);
        self.moved = self.moved.max(moved);
        rest(instance);
    }
}

/// Where an instance is now it has been all the time.
fn rest(instance: &mut Instance) {
    instance.history.rest(&instance.state);
    instance.targets.iter_mut().for_each(|target| target.rest());
    for collider in &mut instance.colliders {
        collider.previous = collider.frame;
    }
}

/// How far anything moved from one state to the other: joints and handles, m, and what is a metre off a joint.
fn moved(before: &State, after: &State) -> f64 {
    let frames = before.frames.iter().zip(&after.frames).map(|(a, b)| {
        let (shift, turn) = a.motion_to(b);
        turn.length().max(shift.length())
    });
    let handles = before.handles.iter().zip(&after.handles);
    let handles = handles.map(|(a, b)| a.distance(*b));
    frames.chain(handles).fold(0.0, f64::max)
}

/// What an instance was before it settled.
pub(crate) struct Before {
    state: State,
    history: History,
    pins: usize,
    was_put: bool,
}

impl Before {
    /// Takes the motion out of an instance, and holds those of the `roots` that nothing holds, since nothing else would stop
    /// their fall.
    pub fn begin(instance: &mut Instance, roots: impl Iterator<Item = usize>) -> Self {
        let before = Self {
            state: instance.state.clone(),
            history: instance.history.clone(),
            pins: instance.pins.len(),
            was_put: instance.was_put,
        };
        for bone in roots {
            if instance.pin_of(bone).is_none() && instance.target_of(bone).is_none() {
                let frame = instance.state.frames[bone];
                instance.pins.push(Pin { bone, frame });
            }
        }
        rest(instance);
        before
    }

    /// Lets the roots go; an instance that has not `settled` is what it was.
    pub fn end(self, instance: &mut Instance, settled: bool) {
        instance.pins.truncate(self.pins);
        if settled {
            instance.was_put = true;
        } else {
            (instance.state, instance.history) = (self.state, self.history);
            instance.was_put = self.was_put;
        }
    }
}

impl<P: Potential> Simulation<P> {
    /// Puts every active instance into equilibrium with what drives and touches it, at rest, as if it had been there for
    /// long: tissue sags, springs give way, and nothing swings when the first step is made. Pinned bones and those with
    /// targets are put where these are; a root that nothing holds stays where it is. Without friction. Returns how far the
    /// last of its iterations still moved anything, m: a hundred-thousandth of a millimetre, but of what has no equilibrium.
    ///
    /// # Errors
    /// As [`Simulation::step`]; everything then is as it was.
    pub async fn settle(&mut self) -> Result<f64> {
        let parents = &self.physics.skeleton.skeleton().parents;
        let roots: Vec<usize> = (0..parents.len())
            .filter(|&j| parents[j].is_none())
            .collect();
        let usual = self.physics.settings;
        self.physics.settings = settings(&usual);
        let active = self.instances.iter_mut().filter(|instance| instance.active);
        let before: Vec<Before> = active
            .map(|instance| Before::begin(instance, roots.iter().copied()))
            .collect();
        let done = self.settle_instances().await;
        self.physics.settings = usual;
        let active = self.instances.iter_mut().filter(|instance| instance.active);
        for (instance, before) in active.zip(before) {
            before.end(instance, done.is_ok());
        }
        done
    }

    async fn settle_instances(&mut self) -> Result<f64> {
        let mut settling = Settling::new();
        while settling.goes_on() {
            (self.substep(true, &mut Timings::default(), &mut |_| ())).await?;
            let active = self.instances.iter_mut().filter(|instance| instance.active);
            active.for_each(|instance| settling.take(instance));
        }
        Ok(settling.moved)
    }

    /// [`Simulation::settle`] on this thread until it is done.
    ///
    /// # Errors
    /// As [`Simulation::settle`].
    pub fn settle_blocking(&mut self) -> Result<f64> {
        pollster::block_on(self.settle())
    }
}
