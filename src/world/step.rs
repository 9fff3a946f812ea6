//! A step of a world.

use super::character::Character;
use super::contents::World;
use super::evaluators::Evaluators;
use crate::math::{Stopwatch, recycled};
use crate::sim::{Instance, Physics, Split, Stepper, Timings};
use crate::{Error, Result};

/// The longest time step, s: a longer one is a jump in time, in which nothing swings.
pub const LONGEST_STEP: f64 = 0.14;

impl World {
    /// Moves everything on by `time_step`, s, which is the time that the host's bones, targets and colliders took from
    /// where they were at the last step to where they are now: hand in the time between the two frames of animation, not that
    /// of the display, since 1 ms of difference at 2 m/s shakes the tissue by 2 mm. A frame longer than
    /// [`Settings::longest_step`](crate::sim::Settings::longest_step), or much longer than the last, takes several steps, in
    /// which all of these move evenly. One longer than [`LONGEST_STEP`] is a jump: bones are put
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
        let time_step = time_step.min(LONGEST_STEP);
        if !jump {
            self.wake_fine_handles();
        }
        let split = self.split(time_step, jump);
        if split.count() > 1 {
            self.begin_frame();
        }
        let mut timings = Timings::default();
        for k in 0..split.count() {
            if split.count() > 1 {
                self.drive_frame(split.part(k));
            }
            let last = k + 1 == split.count();
            let done = self.substep(split.step(k), jump, last, &mut timings).await;
            if done.is_err() && split.count() > 1 {
                self.undo_frame();
            }
            done?;
        }
        self.settings.time_step = time_step;
        self.posed = true;
        timings.step = watch.ms();
        self.timings = timings;
        Ok(())
    }

    /// How a frame is cut into steps.
    fn split(&self, time_step: f64, jump: bool) -> Split {
        let takes_part =
            |(character, used): &(&Character, &bool)| **used && !jump && character.awake;
        let characters = (self.batches.iter()).flat_map(|b| b.characters.iter().zip(&b.used));
        let active = characters.filter(takes_part).map(|(c, _)| &c.instance);
        Split::new(&self.settings, time_step, active)
    }

    /// One step; the `last` of a frame completes the reports.
    pub(super) async fn substep(
        &mut self,
        time_step: f64,
        jump: bool,
        last: bool,
        timings: &mut Timings,
    ) -> Result<()> {
        let watch = Stopwatch::start();
        self.settings.time_step = time_step;
        for batch in &mut self.batches {
            batch.physics.settings.time_step = time_step;
        }
        self.choose(jump);
        self.meet()?;
        self.number()?;
        self.tell_awake()?;
        self.list_links();
        self.begin()?;
        timings.skeleton += watch.ms();
        self.minimise(last, timings).await?;
        self.commit(last);
        self.add_timings(timings);
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

    /// Decides who takes part; those who do not go where they are driven to.
    fn choose(&mut self, jump: bool) {
        let (integrator, time_step) = (self.settings.integrator, self.settings.time_step);
        for batch in &mut self.batches {
            for (character, used) in batch.characters.iter_mut().zip(&batch.used) {
                character.instance.active = *used && character.awake && !jump;
                if *used && jump {
                    character.jump();
                } else if *used && !character.awake {
                    character.ride(integrator, time_step);
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

    async fn minimise(&mut self, last: bool, timings: &mut Timings) -> Result<()> {
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
            .minimise(evaluators, &each, last, timings, &mut |_| ())
            .await;
        self.each = recycled(each);
        done
    }

    fn commit(&mut self, last: bool) {
        let Some(stepper) = &mut self.stepper else {
            return;
        };
        for batch in &mut self.batches {
            stepper.commit(batch.members(), &batch.physics, &mut batch.characters, last);
            for (member, character) in batch.members().zip(&mut batch.characters) {
                if last {
                    stepper.swap_report(member, &mut character.report);
                }
                character.fresh = false;
            }
        }
        if last {
            (self.meetings).report_pushes(stepper, &self.bodies, &mut self.batches);
        }
        for collider in self.colliders.values_mut() {
            collider.previous = collider.frame;
        }
    }

    fn add_timings(&self, timings: &mut Timings) {
        let evaluation = self.evaluators.timings();
        timings.force += evaluation.force;
        timings.hessian += evaluation.hessian;
        timings.readback += evaluation.readback;
    }
}
