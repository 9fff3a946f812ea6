//! Avatars in time.

use super::instance::Instance;
use super::iteration::Observer;
use super::linear_solver::LinearSolver;
use super::report::{InstanceReport, StepReport, Timings};
use super::settings::Settings;
use super::solvers::Solvers;
use super::stepper::{Physics, Stepper};
use super::substeps::{DrivenFrame, Split};
use super::waking::Waking;
use crate::math::{Stopwatch, recycled};
use crate::model::Avatar;
use crate::potential::Potential;
use crate::skeleton::{SkeletonModel, SkeletonPotential};
use crate::{Error, Result};
use glam::DVec3;

/// Avatars of one asset, stepped together.
pub struct Simulation<P> {
    pub(super) potential: P,
    pub(super) physics: Physics,
    pub(super) instances: Vec<Instance>,
    stepper: Stepper,
    /// What drives each instance over a frame that takes several steps.
    frames: Vec<DrivenFrame>,
    /// Memory of the list of all instances.
    each: Vec<(&'static Physics, &'static Instance)>,
}

impl<P: Potential> Simulation<P> {
    /// `potential.instances()` avatars at rest in the bind pose, with the reduced system's solver.
    ///
    /// # Errors
    /// The avatar or the settings are unusable, or the potential is of another asset.
    pub fn new(avatar: &Avatar, potential: P, settings: Settings) -> Result<Self> {
        let solvers = Solvers::dense(potential.pattern(), potential.instances());
        Self::with_solvers(avatar, potential, settings, solvers)
    }

    /// The same with a solver of one's own, which serves all instances in turn.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn with_solver(
        avatar: &Avatar,
        potential: P,
        settings: Settings,
        solver: Box<dyn LinearSolver + Send>,
    ) -> Result<Self> {
        let solvers = Solvers::one(potential.pattern(), solver);
        Self::with_solvers(avatar, potential, settings, solvers)
    }

    fn with_solvers(
        avatar: &Avatar,
        potential: P,
        settings: Settings,
        solvers: Solvers,
    ) -> Result<Self> {
        avatar.validate()?;
        settings.validate()?;
        if potential.space() != avatar.space() {
            return Err(Error::invalid(
                "potential",
                "was made for an avatar with other numbers of bones or handles",
            ));
        }
        let physics = Physics {
            skeleton: SkeletonModel::new(avatar),
            waking: Waking::new(avatar),
            captured_under_gravity: avatar.captured_under_gravity,
            settings,
        };
        let instances: Vec<_> = (0..potential.instances())
            .map(|_| Instance::new(avatar, &settings))
            .collect();
        let members = instances.iter().map(|instance| (&physics, instance));
        Ok(Self {
            stepper: Stepper::new(members, vec![solvers], std::iter::once(instances.len())),
            frames: instances.iter().map(DrivenFrame::new).collect(),
            potential,
            physics,
            instances,
            each: Vec::new(),
        })
    }

    /// The constants.
    pub fn settings(&self) -> &Settings {
        &self.physics.settings
    }

    /// Other constants for the steps that follow; velocities stay what they are, also where the time step changes.
    /// Bending stiffness is the instances' own by now.
    ///
    /// # Errors
    /// They are unusable.
    pub fn set_settings(&mut self, settings: Settings) -> Result<()> {
        settings.validate()?;
        self.physics.settings = settings;
        Ok(())
    }

    /// What evaluates the tissue.
    pub fn potential(&self) -> &P {
        &self.potential
    }

    /// What evaluates the tissue.
    pub fn potential_mut(&mut self) -> &mut P {
        &mut self.potential
    }

    /// The bones' own terms of the next step of an instance, with targets where they are now.
    pub fn skeleton_potential(&self, instance: usize) -> SkeletonPotential {
        self.physics.skeleton_potential(&self.instances[instance])
    }

    /// The instances.
    pub fn instances(&self) -> &[Instance] {
        &self.instances
    }

    /// The instances, to be driven between steps.
    pub fn instances_mut(&mut self) -> &mut [Instance] {
        &mut self.instances
    }

    /// One time step of every active instance: its state, its targets' and colliders' `previous`, and
    /// the drawn skin move on.
    ///
    /// # Errors
    /// Unusable input, a lost device, a linear system that cannot be solved, or a result that is not
    /// finite. Every instance then keeps the state it had.
    pub async fn step(&mut self) -> Result<StepReport> {
        let mut report = StepReport::default();
        self.step_into(&mut report).await?;
        Ok(report)
    }

    /// [`Simulation::step`] with its report written into one that is kept: a step then allocates nothing, but for the
    /// pool's own queue where it is called from a thread outside of it (see [`crate::math::in_pool`]).
    ///
    /// # Errors
    /// As [`Simulation::step`]; the report is then the last one's.
    pub async fn step_into(&mut self, report: &mut StepReport) -> Result<()> {
        self.step_observed(report, &mut |_| ()).await
    }

    /// [`Simulation::step_into`] with an observer of Newton's iterations: for plots of how they converge, and for
    /// comparing solvers and Hessians. It sees what the step works with anyway, so that none of it costs anything.
    ///
    /// # Errors
    /// As [`Simulation::step_into`].
    pub async fn step_observed(
        &mut self,
        report: &mut StepReport,
        observer: &mut Observer<'_>,
    ) -> Result<()> {
        let watch = Stopwatch::start();
        let mut timings = Timings::default();
        self.wake()?;
        let settings = self.physics.settings;
        let active = self.instances.iter().filter(|instance| instance.active);
        let split = Split::new(&settings, settings.time_step, active);
        if split.count() > 1 {
            let pairs = self.frames.iter_mut().zip(&self.instances);
            pairs.for_each(|(frame, instance)| frame.begin(instance));
        }
        let done = self.split_step(&split, &mut timings, observer).await;
        self.physics.settings = settings;
        if done.is_err() && split.count() > 1 {
            let pairs = self.frames.iter().zip(&mut self.instances);
            pairs.for_each(|(frame, instance)| frame.undo(instance));
        }
        done?;
        timings.step = watch.ms();
        report.timings = timings;
        let reports = &mut report.instances;
        reports.resize_with(self.instances.len(), InstanceReport::default);
        for (i, out) in reports.iter_mut().enumerate() {
            self.stepper.swap_report(i, out);
        }
        Ok(())
    }

    /// Wakes the fine handles near what may touch the active instances in this frame.
    fn wake(&mut self) -> Result<()> {
        let Some(waking) = &self.physics.waking else {
            return Ok(());
        };
        for (i, instance) in self.instances.iter_mut().enumerate() {
            if instance.active {
                let colliders = std::mem::take(&mut instance.colliders);
                let budget = self.physics.settings.fine_handles;
                waking.update(instance, &colliders, budget);
                instance.colliders = colliders;
            }
            self.potential.wake(i, &instance.awake)?;
        }
        Ok(())
    }

    /// The steps of a frame.
    async fn split_step(
        &mut self,
        split: &Split,
        timings: &mut Timings,
        observer: &mut Observer<'_>,
    ) -> Result<()> {
        for k in 0..split.count() {
            if split.count() > 1 {
                self.physics.settings.time_step = split.step(k);
                let pairs = self.frames.iter().zip(&mut self.instances);
                for (frame, instance) in pairs.filter(|(_, instance)| instance.active) {
                    frame.drive(instance, split.part(k));
                }
            }
            (self.substep(k + 1 == split.count(), timings, observer)).await?;
        }
        Ok(())
    }

    /// One step; the `last` of a frame completes the reports.
    pub(super) async fn substep(
        &mut self,
        last: bool,
        timings: &mut Timings,
        observer: &mut Observer<'_>,
    ) -> Result<()> {
        let watch = Stopwatch::start();
        let (physics, stepper) = (&self.physics, &mut self.stepper);
        let all = 0..self.instances.len();
        stepper.begin(all.clone(), physics, &self.instances)?;
        timings.skeleton += watch.ms();
        let mut each: Vec<(&Physics, &Instance)> = recycled(std::mem::take(&mut self.each));
        each.extend(self.instances.iter().map(|instance| (physics, instance)));
        let done = stepper
            .minimise(&mut self.potential, &each, last, timings, observer)
            .await;
        self.each = recycled(each);
        done?;
        stepper.commit(all, physics, &mut self.instances, last);
        let evaluation = self.potential.timings();
        timings.force += evaluation.force;
        timings.hessian += evaluation.hessian;
        timings.readback += evaluation.readback;
        Ok(())
    }

    /// [`Simulation::step`] on this thread until it is done.
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub fn step_blocking(&mut self) -> Result<StepReport> {
        pollster::block_on(self.step())
    }

    /// Copies out the drawn skin of an instance: positions (m, world) and normals.
    ///
    /// # Errors
    /// A lost device.
    pub fn read_skin_blocking(
        &mut self,
        instance: usize,
        positions: &mut Vec<DVec3>,
        normals: &mut Vec<DVec3>,
    ) -> Result<()> {
        pollster::block_on(self.potential.read_skin(instance, positions, normals))
    }
}
