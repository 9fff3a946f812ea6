//! A step of a world.

use super::contents::World;
use super::evaluators::Evaluators;
use crate::math::{Stopwatch, recycled};
use crate::sim::{Instance, Physics, Stepper, Timings};
use crate::{Error, Result};

/// The longest time step, s: a longer one is a jump in time, in which nothing swings.
pub const LONGEST_STEP: f64 = 0.14;

impl World {
    /// Moves everything on by `time_step`, s, which is the time that the host's bones, targets and colliders took from
    /// where they were at the last step to where they are now. One longer than [`LONGEST_STEP`] is a jump: bones are put
    /// where they are driven to, and tissue goes with them.
    ///
    /// # Errors
    /// A time step that is not positive; what was written into an instance and is unusable; a lost device; a result that
    /// is not finite. Everything then is as it was.
    pub async fn step(&mut self, time_step: f64) -> Result<()> {
        let watch = Stopwatch::start();
        if !(time_step > 0.0 && time_step.is_finite()) {
            let problem = format!("{time_step} is not a positive number of seconds");
            return Err(Error::invalid("time_step", problem));
        }
        let jump = time_step > LONGEST_STEP;
        self.set_time_step(time_step.min(LONGEST_STEP));
        self.choose(jump);
        self.meet()?;
        self.number()?;
        self.list_links();
        let mut timings = Timings::default();
        self.begin()?;
        timings.skeleton = watch.ms();
        self.minimise(&mut timings).await?;
        self.commit();
        self.posed = true;
        self.report(&mut timings);
        timings.step = watch.ms();
        self.timings = timings;
        Ok(())
    }

    /// [`World::step`] on this thread until it is done.
    ///
    /// # Errors
    /// As [`World::step`].
    #[cfg(not(target_arch = "wasm32"))]
    pub fn step_blocking(&mut self, time_step: f64) -> Result<()> {
        pollster::block_on(self.step(time_step))
    }

    /// Velocities stay what they are where the time step changes.
    fn set_time_step(&mut self, time_step: f64) {
        let ratio = time_step / self.settings.time_step;
        self.settings.time_step = time_step;
        for batch in &mut self.batches {
            if ratio != 1.0 {
                let instances = batch.characters.iter_mut().map(|c| &mut c.instance);
                instances.for_each(|instance| instance.stretch_last_step(ratio));
            }
            batch.physics.settings.time_step = time_step;
        }
    }

    /// Decides who takes part; those who do not go where they are driven to.
    fn choose(&mut self, jump: bool) {
        for batch in &mut self.batches {
            for (character, used) in batch.characters.iter_mut().zip(&batch.used) {
                character.instance.active = *used && character.awake && !jump;
                if *used && jump {
                    character.jump();
                } else if *used && !character.awake {
                    character.ride();
                }
            }
        }
    }

    /// Numbers the members anew and makes memory for their steps, where any have come or gone.
    pub(super) fn number(&mut self) -> Result<()> {
        if self.stepper.is_some() {
            return Ok(());
        }
        let counts = self.batches.iter().map(|b| b.characters.len());
        self.evaluators.number(counts)?;
        let mut first = 0;
        for batch in &mut self.batches {
            batch.first = first;
            first += batch.characters.len();
        }
        let solvers = self.batches.iter().zip(self.evaluators.iter());
        let solvers = solvers.map(|(b, evaluator)| b.solvers(evaluator)).collect();
        let members = self.batches.iter().flat_map(|batch| {
            let characters = batch.characters.iter();
            characters.map(|character| (&batch.physics, &character.instance))
        });
        let counts = self.batches.iter().map(|b| b.characters.len());
        self.stepper = Some(Stepper::new(members, solvers, counts));
        Ok(())
    }

    /// Checks and predicts all members; the frames of bodies are the bodies'.
    fn begin(&mut self) -> Result<()> {
        let Some(stepper) = &mut self.stepper else {
            return Ok(());
        };
        let links = &self.meetings.links;
        stepper.join(links);
        for batch in &self.batches {
            let begun = stepper.begin(batch.members(), &batch.physics, &batch.characters);
            begun.map_err(|e| e.within(&batch.avatar.name))?;
            for (member, character) in batch.members().zip(&batch.characters) {
                if character.fresh {
                    stepper.forget_end(member);
                }
                for slot in 0..batch.avatar.body_slots {
                    let frame = batch.avatar.bones() + slot;
                    if !links.iter().any(|l| l.member == member && l.frame == frame) {
                        stepper.hold(member, frame);
                    }
                }
            }
        }
        links.iter().for_each(|link| stepper.follow_body(link));
        Ok(())
    }

    async fn minimise(&mut self, timings: &mut Timings) -> Result<()> {
        let Some(stepper) = &mut self.stepper else {
            return Ok(());
        };
        // A list, not an iterator with closures: with such a one the future would not be `Send`.
        let mut each: Vec<(&Physics, &Instance)> = recycled(std::mem::take(&mut self.each));
        for batch in &self.batches {
            let instances = batch.characters.iter().map(|c| &c.instance);
            each.extend(instances.map(|instance| (&batch.physics, instance)));
        }
        let evaluators: &mut Evaluators = &mut self.evaluators;
        let done = stepper
            .minimise(evaluators, &each, timings, &mut |_| ())
            .await;
        self.each = recycled(each);
        done
    }

    fn commit(&mut self) {
        let Some(stepper) = &mut self.stepper else {
            return;
        };
        for batch in &mut self.batches {
            stepper.commit(batch.members(), &batch.physics, &mut batch.characters);
            for (member, character) in batch.members().zip(&mut batch.characters) {
                stepper.swap_report(member, &mut character.report);
                character.fresh = false;
            }
        }
        self.meetings
            .report_pushes(stepper, &self.bodies, &mut self.batches);
        for collider in self.colliders.values_mut() {
            collider.previous = collider.frame;
        }
    }

    fn report(&self, timings: &mut Timings) {
        let evaluation = self.evaluators.timings();
        timings.force += evaluation.force;
        timings.hessian += evaluation.hessian;
        timings.readback += evaluation.readback;
    }
}
