//! The split rule: how a frame of a host is cut into steps, and where what it drives is in between (method §5).
//!
//! BDF2 is stable where no step is more than 1 + √2 times as long as the one before, and follows swings of a few Hz where
//! none is longer than about 17 ms. So a frame of h that follows on a step of g takes
//!
//! ```text
//! h_k = s min(2ᵏ g, L),  k = 1 … m,   Σ h_k = h
//! ```
//!
//! with L the longest step, the least m that reaches h, and one factor s ≤ 1. After a start from rest there is no g. One from
//! a velocity takes h/4, h/4 and h/2: its first step is of first order.

use super::instance::Instance;
use super::settings::Settings;
use crate::model::{Frame, History, Integrator, State};

/// The lengths of the steps of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Split {
    frame: f64,
    /// Length of the step before, s.
    before: f64,
    longest: f64,
    /// Quarters, quarters and halves in place of the rule.
    starts_moving: bool,
    /// How many steps, and what they sum to before they are scaled.
    count: usize,
    sum: f64,
}

impl Split {
    /// Of a frame of `time_step` (s) of all these instances together.
    pub fn new<'a>(
        settings: &Settings,
        time_step: f64,
        active: impl Iterator<Item = &'a Instance>,
    ) -> Self {
        let mut out = Self {
            frame: time_step,
            before: f64::INFINITY,
            longest: settings.longest_step,
            starts_moving: false,
            count: 1,
            sum: time_step,
        };
        if settings.integrator != Integrator::Bdf2 {
            return out;
        }
        for instance in active {
            if instance.history.is_continued() {
                out.before = out.before.min(instance.history.last_step());
            }
            out.starts_moving |= instance.history.starts_moving(&instance.state);
        }
        if out.starts_moving && time_step <= out.longest {
            out.count = 3;
            return out;
        }
        if out.starts_moving {
            out.before = out.before.min(out.longest / 8.0);
            out.starts_moving = false;
        }
        out.sum = out.unscaled(1);
        // Rounding of a frame that is as long as the longest step, or twice the last one, makes no second step.
        while out.sum < time_step * (1.0 - 1e-9) {
            out.count += 1;
            out.sum += out.unscaled(out.count);
        }
        out
    }

    /// min(2ᵏ g, L).
    fn unscaled(&self, k: usize) -> f64 {
        let growth = 2f64.powi(k.min(64) as i32);
        (growth * self.before).min(self.longest)
    }

    /// How many steps.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Length of step `k`, from 0 on, s.
    pub fn step(&self, k: usize) -> f64 {
        match (self.count, self.starts_moving) {
            (1, _) => self.frame,
            (_, true) => self.frame * [0.25, 0.25, 0.5][k],
            _ => self.unscaled(k + 1) * (self.frame / self.sum),
        }
    }

    /// The part of the frame that is over where step `k` ends.
    pub fn part(&self, k: usize) -> f64 {
        match k + 1 == self.count {
            true => 1.0,
            false => (0..=k).map(|k| self.step(k)).sum::<f64>() / self.frame,
        }
    }
}

/// What drives an instance over a whole frame, and what it was before; kept from frame to frame.
#[derive(Debug)]
pub(crate) struct DrivenFrame {
    state: State,
    history: History,
    pins: Vec<[Frame; 2]>,
    targets: Vec<[Frame; 3]>,
    colliders: Vec<[Frame; 2]>,
}

impl DrivenFrame {
    /// Of `instance` at a frame's start.
    pub fn new(instance: &Instance) -> Self {
        let mut out = Self {
            state: instance.state.clone(),
            history: instance.history.clone(),
            pins: Vec::new(),
            targets: Vec::new(),
            colliders: Vec::new(),
        };
        out.begin(instance);
        out
    }

    /// [`DrivenFrame::new`] in the memory that is there.
    pub fn begin(&mut self, instance: &Instance) {
        self.state.clone_from(&instance.state);
        self.history.clone_from(&instance.history);
        let frames = &instance.state.frames;
        self.pins.clear();
        let pins = instance.pins.iter();
        // A pin of a bone that is not there is an error of the step.
        let start = |bone: usize, end| frames.get(bone).copied().unwrap_or(end);
        (self.pins).extend(pins.map(|pin| [start(pin.bone, pin.frame), pin.frame]));
        self.targets.clear();
        let targets = instance.targets.iter();
        (self.targets).extend(targets.map(|t| [t.previous, t.frame, t.earlier]));
        self.colliders.clear();
        let colliders = instance.colliders.iter();
        (self.colliders).extend(colliders.map(|c| [c.previous, c.frame]));
    }

    /// Puts pins, targets and colliders where they are at the end of a `part` of the frame.
    pub fn drive(&self, instance: &mut Instance, part: f64) {
        for (pin, [start, end]) in instance.pins.iter_mut().zip(&self.pins) {
            pin.frame = start.between(end, part);
        }
        for (target, [start, end, _]) in instance.targets.iter_mut().zip(&self.targets) {
            target.frame = start.between(end, part);
        }
        for (collider, [start, end]) in instance.colliders.iter_mut().zip(&self.colliders) {
            collider.frame = start.between(end, part);
        }
    }

    /// Makes `instance` what it was before the frame.
    pub fn undo(&self, instance: &mut Instance) {
        instance.state.clone_from(&self.state);
        instance.history.clone_from(&self.history);
        for (pin, [_, end]) in instance.pins.iter_mut().zip(&self.pins) {
            pin.frame = *end;
        }
        for (target, [start, end, earlier]) in instance.targets.iter_mut().zip(&self.targets) {
            (target.previous, target.frame, target.earlier) = (*start, *end, *earlier);
        }
        for (collider, [start, end]) in instance.colliders.iter_mut().zip(&self.colliders) {
            (collider.previous, collider.frame) = (*start, *end);
        }
    }
}
