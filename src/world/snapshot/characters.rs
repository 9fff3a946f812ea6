//! What a character's state and driver are.

use super::sections::damaged;
use crate::Result;
use crate::model::{Awake, Frame, History, State};
use crate::potential::TissueFactors;
use crate::sim::{Pin, SpringMode, WakingMemory};
use crate::skeleton::{Bending, JointLimit, Preload, Tracking};
use crate::world::{Character, Driving};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

#[derive(Serialize, Deserialize)]
pub(super) struct StoredState {
    pub state: State,
    pub previous: State,
}

/// What came before a state, where each target was, and what joints damp.
#[derive(Serialize, Deserialize)]
pub(super) struct StoredHistory {
    pub history: History,
    pub inertia_share: f64,
    pub earlier_targets: Vec<Frame>,
    pub bending_damping: Vec<f64>,
    pub limit_damping: Vec<f64>,
    pub preload: Preload,
}

/// Which fine handles are awake in the state and those before it.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct StoredFine {
    pub awake: Awake,
    pub memory: WakingMemory,
}

/// What the states do not say of spring bones.
#[derive(Serialize, Deserialize)]
pub(super) struct StoredSprings {
    pub mode: SpringMode,
    pub file_axes: DMat3,
}

#[derive(Serialize, Deserialize)]
pub(super) struct StoredDriver<F> {
    pub driving: Driving,
    pub placement: Frame,
    pub awake: bool,
    pub targets: Vec<Tracking>,
    pub pins: Vec<Pin>,
    pub bending: Vec<Bending>,
    pub limits: Vec<JointLimit>,
    pub gravity: DVec3,
    pub factors: F,
}

/// [`TissueFactors`] in drivers of version 1: no tension.
#[derive(Serialize, Deserialize)]
pub(super) struct FactorsWithoutTension {
    pub stiffness: f64,
    pub damping: f64,
    pub gravity: f64,
    pub friction: f64,
}

impl From<FactorsWithoutTension> for TissueFactors {
    fn from(stored: FactorsWithoutTension) -> Self {
        Self {
            stiffness: stored.stiffness,
            damping: stored.damping,
            gravity: stored.gravity,
            friction: stored.friction,
            ..Self::default()
        }
    }
}

impl From<StoredDriver<FactorsWithoutTension>> for StoredDriver<TissueFactors> {
    fn from(stored: StoredDriver<FactorsWithoutTension>) -> Self {
        Self {
            driving: stored.driving,
            placement: stored.placement,
            awake: stored.awake,
            targets: stored.targets,
            pins: stored.pins,
            bending: stored.bending,
            limits: stored.limits,
            gravity: stored.gravity,
            factors: stored.factors.into(),
        }
    }
}

impl Character {
    pub(super) fn stored_state(&self) -> StoredState {
        let instance = self.instance();
        StoredState {
            state: instance.state.clone(),
            previous: instance.history.previous().clone(),
        }
    }

    pub(super) fn stored_driver(&self) -> StoredDriver<TissueFactors> {
        let instance = self.instance();
        StoredDriver {
            driving: self.driving(),
            placement: self.placement(),
            awake: self.is_awake(),
            targets: instance.targets.clone(),
            pins: instance.pins.clone(),
            bending: instance.bending.clone(),
            limits: instance.limits.clone(),
            gravity: instance.gravity,
            factors: instance.factors,
        }
    }

    pub(super) fn stored_history(&self) -> StoredHistory {
        let instance = self.instance();
        StoredHistory {
            history: instance.history.clone(),
            inertia_share: instance.inertia_share,
            earlier_targets: instance.targets.iter().map(|t| t.earlier).collect(),
            bending_damping: instance.bending.iter().map(|b| b.damping).collect(),
            limit_damping: instance.limits.iter().map(|l| l.damping_time).collect(),
            preload: instance.preload,
        }
    }

    pub(super) fn stored_springs(&self) -> StoredSprings {
        let instance = self.instance();
        StoredSprings {
            mode: instance.springs,
            file_axes: instance.file_axes,
        }
    }

    pub(super) fn stored_fine(&self) -> StoredFine {
        let instance = self.instance();
        StoredFine {
            awake: instance.awake.clone(),
            memory: instance.waking.clone(),
        }
    }

    /// `time_step` is that which led to the state, s.
    pub(super) fn restore_state(
        &mut self,
        stored: StoredState,
        history: Option<StoredHistory>,
        fine: StoredFine,
        time_step: f64,
    ) -> Result<()> {
        let avatar = self.avatar.clone();
        let instance = &mut self.instance;
        let like = instance.state.clone();
        instance.state = stored.state;
        let previous = stored.previous;
        match history {
            Some(stored) => {
                let counted = stored.earlier_targets.len() == instance.targets.len()
                    && stored.bending_damping.len() == instance.bending.len()
                    && stored.limit_damping.len() == instance.limits.len();
                if !counted {
                    return Err(damaged());
                }
                let bending = instance.bending.iter_mut().zip(stored.bending_damping);
                bending.for_each(|(bending, damping)| bending.damping = damping);
                let limits = instance.limits.iter_mut().zip(stored.limit_damping);
                limits.for_each(|(limit, damping)| limit.damping_time = damping);
                let targets = instance.targets.iter_mut().zip(stored.earlier_targets);
                targets.for_each(|(target, earlier)| target.earlier = earlier);
                instance.preload = stored.preload;
                instance.history = stored.history;
                instance.inertia_share = stored.inertia_share;
            }
            None => {
                instance.preload = Preload::Off;
                if previous.space() != instance.state.space() {
                    return Err(damaged());
                }
                let history = &mut instance.history;
                history.set_previous(&previous, &instance.state, time_step);
                let targets = instance.targets.iter_mut();
                targets.for_each(|target| target.earlier = target.previous);
            }
        }
        fine.awake.validate(&avatar)?;
        instance.awake.clone_from(&fine.awake);
        instance.waking = fine.memory;
        let handles = instance.state.handles.len();
        let past = instance.history.states_mut().iter_mut();
        for state in std::iter::once(&mut instance.state).chain(past) {
            if state.handles.len() != handles {
                return Err(damaged());
            }
            state.awake.clear();
            state.awake.extend(fine.awake.handles());
        }
        // There may be more room here, for bodies and for fine handles.
        let frames = instance.state.frames.len();
        if !(avatar.bones()..=like.frames.len()).contains(&frames)
            || instance.bending.len() != frames
        {
            return Err(damaged());
        }
        self.set_avatar(&avatar);
        self.instance.validate(&like)
    }

    pub(super) fn restore(
        &mut self,
        state: StoredState,
        history: Option<StoredHistory>,
        driver: StoredDriver<TissueFactors>,
        springs: &StoredSprings,
        fine: StoredFine,
        time_step: f64,
    ) -> Result<()> {
        let instance = &mut self.instance;
        instance.targets = driver.targets;
        instance.pins = driver.pins;
        instance.bending = driver.bending;
        instance.limits = driver.limits;
        instance.gravity = driver.gravity;
        instance.factors = driver.factors;
        instance.springs = springs.mode;
        instance.file_axes = springs.file_axes;
        self.restore_state(state, history, fine, time_step)?;
        self.restore_driving(driver.driving, &driver.placement, driver.awake)
    }
}
