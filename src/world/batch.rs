//! The instances of one asset in a world, and all assets' together as a step sees them.

use super::backend::{Evaluator, Opened, Room};
use super::character::Character;
use super::near::SkinBounds;
use crate::Result;
use crate::math::recycled;
use crate::model::{Avatar, State};
use crate::potential::{BlockPattern, Evaluation, HessianForm, StepStart, Trial};
use crate::sim::internal::{Members, Physics, Solvers};
use crate::sim::Settings;
use crate::skeleton::SkeletonModel;
use std::ops::Range;
use std::sync::Arc;

/// One asset: an avatar and its instances, or a rigid body, which is an avatar of one bone.
pub(super) struct Batch {
    /// As it was handed in.
    base: Arc<Avatar>,
    /// That with body slots.
    pub avatar: Arc<Avatar>,
    pub physics: Physics,
    pub evaluator: Evaluator,
    pub bounds: SkinBounds,
    /// As many as there is room for; those without a key are unused.
    pub characters: Vec<Character>,
    /// Which of them are in use.
    pub used: Vec<bool>,
    pub room: Room,
    /// Its first member.
    pub first: usize,
    pub is_body: bool,
    /// Memory of an energy difference's trials, and whose they are.
    trials: Vec<Trial<'static>>,
    places: Vec<usize>,
    differences: Vec<f64>,
}

impl Batch {
    pub fn new(opened: &Opened, base: Arc<Avatar>, settings: Settings, is_body: bool) -> Result<Self> {
        base.validate()?;
        let room = Room::default();
        let evaluator = match is_body {
            true => Evaluator::cpu(&base, room)?,
            false => opened.evaluator(&base, room)?,
        };
        Ok(Self {
            avatar: base.clone(),
            physics: Physics {
                skeleton: SkeletonModel::new(&base),
                captured_under_gravity: base.captured_under_gravity,
                settings,
            },
            evaluator,
            bounds: SkinBounds::new(&base),
            characters: Vec::new(),
            used: Vec::new(),
            room,
            first: 0,
            is_body,
            trials: Vec::new(),
            places: Vec::new(),
            differences: Vec::new(),
            base,
        })
    }

    /// Its members.
    pub fn members(&self) -> Range<usize> {
        self.first..self.first + self.characters.len()
    }

    /// Makes room; tells whether anything had to be made anew. Nothing has changed where it fails.
    pub fn make_room(&mut self, opened: &Opened, wanted: Room) -> Result<bool> {
        let room = self.room.union(wanted);
        if room == self.room {
            return Ok(false);
        }
        let room = self.room.union(room.rounded_up());
        let avatar = match room.body_slots {
            0 => self.base.clone(),
            slots => Arc::new((*self.base).clone().with_body_slots(slots)?),
        };
        self.evaluator = match self.is_body {
            true => Evaluator::cpu(&avatar, room)?,
            false => opened.evaluator(&avatar, room)?,
        };
        self.physics.skeleton = SkeletonModel::new(&avatar);
        (self.characters.iter_mut()).for_each(|character| character.set_avatar(&avatar));
        self.avatar = avatar;
        self.room = room;
        Ok(true)
    }

    /// Solvers of its systems.
    pub fn solvers(&self) -> Solvers {
        Solvers::dense(self.evaluator.pattern(), self.characters.len())
    }
}

/// All assets of a world; their members are numbered one after another.
#[derive(Default)]
pub(super) struct Batches {
    pub list: Vec<Batch>,
    /// Of each member.
    pub batch_of: Vec<usize>,
}

impl Batches {
    /// Numbers the members anew.
    pub fn number(&mut self) {
        self.batch_of.clear();
        for (b, batch) in self.list.iter_mut().enumerate() {
            batch.first = self.batch_of.len();
            let count = batch.characters.len();
            self.batch_of.extend(std::iter::repeat_n(b, count));
        }
    }

    /// The batch of a member, and which of its instances it is.
    pub fn of_member(&mut self, member: usize) -> (&mut Batch, usize) {
        let batch = &mut self.list[self.batch_of[member]];
        let place = member - batch.first;
        (batch, place)
    }
}

impl Members for Batches {
    fn asset(&self, member: usize) -> usize {
        self.batch_of[member]
    }

    fn pattern(&self, member: usize) -> &BlockPattern {
        self.list[self.batch_of[member]].evaluator.pattern()
    }

    fn hessian_form(&self, member: usize) -> HessianForm {
        self.list[self.batch_of[member]].evaluator.hessian_form()
    }

    async fn begin_step(&mut self, starts: &[StepStart<'_>], active: &[bool]) -> Result<()> {
        for batch in &mut self.list {
            let range = batch.members();
            if active[range.clone()].contains(&true) {
                (batch.evaluator)
                    .begin_step(&starts[range.clone()], &active[range])
                    .await?;
            }
        }
        Ok(())
    }

    async fn evaluate(
        &mut self,
        states: &[State],
        wanted: &[bool],
        out: &mut [Evaluation],
    ) -> Result<()> {
        for batch in &mut self.list {
            let range = batch.members();
            if wanted[range.clone()].contains(&true) {
                let (states, wanted) = (&states[range.clone()], &wanted[range.clone()]);
                (batch.evaluator)
                    .evaluate(states, wanted, &mut out[range])
                    .await?;
            }
        }
        Ok(())
    }

    async fn energy_differences(&mut self, trials: &[Trial<'_>], out: &mut [f64]) -> Result<()> {
        for batch in &mut self.list {
            let range = batch.members();
            let mut of_batch: Vec<Trial<'_>> = recycled(std::mem::take(&mut batch.trials));
            batch.places.clear();
            for (k, trial) in trials.iter().enumerate() {
                if range.contains(&trial.instance) {
                    of_batch.push(Trial {
                        instance: trial.instance - range.start,
                        ..*trial
                    });
                    batch.places.push(k);
                }
            }
            batch.differences.resize(of_batch.len(), 0.0);
            if !of_batch.is_empty() {
                let differences = &mut batch.differences;
                (batch.evaluator)
                    .energy_differences(&of_batch, differences)
                    .await?;
            }
            for (&k, difference) in batch.places.iter().zip(&batch.differences) {
                out[k] = *difference;
            }
            batch.trials = recycled(of_batch);
        }
        Ok(())
    }

    async fn pose_skin(&mut self, states: &[State]) -> Result<()> {
        for batch in &mut self.list {
            let range = batch.members();
            if !range.is_empty() {
                batch.evaluator.pose_skin(&states[range]).await?;
            }
        }
        Ok(())
    }
}
