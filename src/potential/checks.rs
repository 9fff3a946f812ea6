//! What every evaluation demands of its input: one condition has one error, whoever evaluates.

use super::{PreviousSkin, StepStart, Trial};
use crate::model::{Avatar, OffsetLimits, Space, State};
use crate::{Error, Result};

/// What the input of a batch of one asset is held against.
#[derive(Clone, Debug)]
pub(crate) struct Checks {
    space: Space,
    instances: usize,
    /// Frames that may carry colliders.
    body_frames: Vec<u32>,
    offsets: OffsetLimits,
}

impl Checks {
    /// For `instances` of `avatar`.
    pub fn new(avatar: &Avatar, instances: usize) -> Self {
        Self {
            space: avatar.space(),
            instances,
            body_frames: avatar.body_frames(),
            offsets: OffsetLimits::new(avatar),
        }
    }

    /// That a list has an entry for each instance.
    pub fn count(&self, field: &str, count: usize) -> Result<()> {
        if count == self.instances {
            return Ok(());
        }
        let problem = format!("{count} given for {} instances", self.instances);
        Err(Error::invalid(field, problem))
    }

    /// That there is such an instance.
    pub fn instance(&self, instance: usize) -> Result<()> {
        if instance < self.instances {
            return Ok(());
        }
        let problem = format!("{instance} of {}", self.instances);
        Err(Error::invalid("instance", problem))
    }

    /// That an instance is there and has `begun` a step.
    pub fn begun(&self, instance: usize, begun: bool) -> Result<()> {
        self.instance(instance)?;
        if begun {
            return Ok(());
        }
        let problem = format!("{instance} has begun no step: call begin_step first");
        Err(Error::invalid("instance", problem))
    }

    /// That a state is one of this asset, and finite.
    pub fn state(&self, state: &State) -> Result<()> {
        if state.space() != self.space {
            let problem = format!("has {:?}, expected {:?}", state.space(), self.space);
            return Err(Error::invalid("state", problem));
        }
        if !state.is_finite() {
            return Err(Error::NotFinite { quantity: "state" });
        }
        Ok(())
    }

    /// The input of `begin_step`.
    pub fn starts(&self, starts: &[StepStart<'_>], active: &[bool]) -> Result<()> {
        self.count("starts", starts.len())?;
        self.count("active", active.len())?;
        let started = starts.iter().zip(active).filter(|(_, active)| **active);
        for (start, _) in started {
            self.state(start.current)?;
            for past in start.inertia.past {
                self.state(past)?;
            }
            let (weights, step) = (start.inertia.weights, start.inertia.step);
            let weighs = weights.iter().all(|c| c.is_finite()) && start.inertia.drift.is_finite();
            if start.inertia.past.len() > 3 || !(weighs && step > 0.0 && step.is_finite()) {
                let problem = "holds more than three states, or a number that is none";
                return Err(Error::invalid("inertia", problem));
            }
            if !(start.time_step > 0.0 && start.time_step.is_finite()) {
                let problem = format!("{}; must be positive (s)", start.time_step);
                return Err(Error::invalid("time_step", problem));
            }
            if !start.tissue_gravity.is_finite() {
                return Err(Error::invalid("tissue_gravity", "is not finite"));
            }
            let prescribed = start.prescribed.len();
            if prescribed != 0 && prescribed != self.space.frames {
                let problem = format!("{prescribed} given for {} frames", self.space.frames);
                return Err(Error::invalid("prescribed", problem));
            }
            start.factors.validate()?;
            self.offsets.check(start.pose_offsets)?;
            start.validate_contact(&self.body_frames)?;
        }
        Ok(())
    }

    /// The input of `evaluate`; `begun` tells which instances have begun a step.
    pub fn states(
        &self,
        states: &[State],
        active: &[bool],
        out: usize,
        begun: impl Fn(usize) -> bool,
    ) -> Result<()> {
        self.count("states", states.len())?;
        self.count("active", active.len())?;
        self.count("out", out)?;
        for i in (0..states.len()).filter(|&i| active[i]) {
            self.state(&states[i])?;
            self.begun(i, begun(i))?;
        }
        Ok(())
    }

    /// The input of `energy_differences`.
    pub fn trials(
        &self,
        trials: &[Trial<'_>],
        out: usize,
        begun: impl Fn(usize) -> bool,
    ) -> Result<()> {
        if out != trials.len() {
            return Err(Error::invalid("out", "must be as long as trials"));
        }
        for trial in trials {
            self.instance(trial.instance)?;
            self.begun(trial.instance, begun(trial.instance))?;
            self.state(trial.base)?;
            self.state(trial.state)?;
        }
        Ok(())
    }

    /// The input of `pose_skin`.
    pub fn poses(
        &self,
        states: &[State],
        offsets: &[&[[f32; 3]]],
        previous: &[PreviousSkin],
    ) -> Result<()> {
        self.count("states", states.len())?;
        if !offsets.is_empty() {
            self.count("offsets", offsets.len())?;
        }
        for offsets in offsets {
            self.offsets.check(offsets)?;
        }
        if !previous.is_empty() {
            self.count("previous", previous.len())?;
        }
        states.iter().try_for_each(|state| self.state(state))
    }
}
