//! Avatars in time.

use super::dense_cholesky::DenseCholesky;
use super::instance::Instance;
use super::iteration::Observer;
use super::linear_solver::LinearSolver;
use super::minimisation::Minimisation;
use super::newton::Newton;
use super::prediction::{fall_back, predict};
use super::report::{InstanceReport, Load, StepReport, Timings};
use super::settings::Settings;
use super::step_end::StepEnds;
use super::step_start::{skeleton_start, tissue_start};
use crate::math::{Stopwatch, recycled};
use crate::model::Avatar;
use crate::potential::{Potential, StepStart};
use crate::skeleton::{SkeletonModel, SkeletonPotential, joint_gap};
use crate::{Error, Result};
use glam::DVec3;

/// Avatars of one asset, stepped together by backward Euler.
pub struct Simulation<P: Potential> {
    pub(super) potential: P,
    solver: Box<dyn LinearSolver + Send + Sync>,
    pub(super) settings: Settings,
    pub(super) skeleton: SkeletonModel,
    pub(super) captured_under_gravity: bool,
    pub(super) instances: Vec<Instance>,
    newton: Newton,
    /// Memory of the starts of a step.
    starts: Vec<StepStart<'static>>,
    ends: StepEnds,
}

impl<P: Potential> Simulation<P> {
    /// `potential.instances()` avatars at rest in the bind pose, with the reduced system's solver.
    ///
    /// # Errors
    /// The avatar or the settings are unusable, or the potential is of another asset.
    pub fn new(avatar: &Avatar, potential: P, settings: Settings) -> Result<Self> {
        let solver = Box::new(DenseCholesky::new(potential.pattern()));
        Self::with_solver(avatar, potential, settings, solver)
    }

    /// The same with a solver of one's own.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn with_solver(
        avatar: &Avatar,
        potential: P,
        settings: Settings,
        solver: Box<dyn LinearSolver + Send + Sync>,
    ) -> Result<Self> {
        avatar.validate()?;
        settings.validate()?;
        if potential.space() != avatar.space() {
            return Err(Error::invalid(
                "potential",
                "was made for an avatar with other numbers of bones or handles",
            ));
        }
        let skeleton = SkeletonModel::new(avatar);
        let instances: Vec<_> = (0..potential.instances())
            .map(|_| Instance::new(avatar, &settings))
            .collect();
        let minimisations = instances
            .iter()
            .map(|instance| {
                let start = skeleton_start(&settings, instance);
                let skeleton = SkeletonPotential::new(&skeleton, &start);
                Minimisation::new(skeleton, instance.state.clone())
            })
            .collect();
        Ok(Self {
            newton: Newton::new(minimisations, &avatar.rest_state()),
            potential,
            solver,
            settings,
            skeleton,
            captured_under_gravity: avatar.captured_under_gravity,
            starts: Vec::new(),
            ends: StepEnds::new(instances.len()),
            instances,
        })
    }

    /// The constants.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Other constants for the steps that follow; velocities stay what they are, also where the time step changes.
    /// Bending stiffness is the instances' own by now.
    ///
    /// # Errors
    /// They are unusable.
    pub fn set_settings(&mut self, settings: Settings) -> Result<()> {
        settings.validate()?;
        let ratio = settings.time_step / self.settings.time_step;
        if ratio != 1.0 {
            for instance in &mut self.instances {
                // qⁿ⁻¹ is where it would have been a new time step ago.
                let step = instance.previous.step_to(&instance.state);
                instance.previous = instance.state.moved(&step, -ratio);
            }
        }
        self.settings = settings;
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
        let start = skeleton_start(&self.settings, &self.instances[instance]);
        SkeletonPotential::new(&self.skeleton, &start)
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
        self.begin_step(&mut timings).await?;
        let (newton, solver) = (&mut self.newton, &mut *self.solver);
        newton
            .minimise(
                &mut self.potential,
                solver,
                self.settings.solver,
                &mut timings,
                observer,
            )
            .await?;
        for (state, active) in newton.iterates.states.iter().zip(&newton.active) {
            if *active && !state.is_finite() {
                return Err(Error::NotFinite { quantity: "state" });
            }
        }
        let end = Stopwatch::start();
        let always = self.settings.report_at_end;
        let wanted = (self.instances.iter()).map(|i| always || !i.pins.is_empty());
        (self.ends)
            .report(&mut self.potential, &mut self.newton, wanted)
            .await?;
        timings.evaluation += end.ms();
        let skin = Stopwatch::start();
        self.potential
            .pose_skin(&self.newton.iterates.states)
            .await?;
        timings.skin = skin.ms();
        self.commit();
        let evaluation = self.potential.timings();
        timings.force = evaluation.force;
        timings.hessian = evaluation.hessian;
        timings.readback = evaluation.readback;
        timings.step = watch.ms();
        report.timings = timings;
        let count = self.instances.len();
        report.instances.resize_with(count, InstanceReport::default);
        let minimisations = &mut self.newton.minimisations;
        for (out, minimisation) in report.instances.iter_mut().zip(minimisations) {
            std::mem::swap(out, &mut minimisation.report);
        }
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

    /// Checks the input, predicts, and starts the potential's step.
    async fn begin_step(&mut self, timings: &mut Timings) -> Result<()> {
        let watch = Stopwatch::start();
        for (i, instance) in self.instances.iter().enumerate() {
            self.newton.active[i] = instance.active;
            let minimisation = &mut self.newton.minimisations[i];
            minimisation.report.reset();
            if !instance.active {
                self.newton.iterates.states[i].clone_from(&instance.state);
                continue;
            }
            instance.validate(&minimisation.current)?;
            let start = skeleton_start(&self.settings, instance);
            minimisation.skeleton.restart(&self.skeleton, &start);
            minimisation.current.clone_from(&instance.state);
            let skeleton = self.skeleton.skeleton();
            fall_back(skeleton, instance, &mut self.newton.fallbacks.states[i]);
            predict(skeleton, instance, &mut self.newton.iterates.states[i]);
            minimisation.fixed.fill(false);
            minimisation.prescribed.fill(false);
            for pin in &instance.pins {
                minimisation.prescribed[pin.bone] = true;
                minimisation.fixed[6 * pin.bone..6 * pin.bone + 6].fill(true);
            }
        }
        timings.skeleton += watch.ms();
        let watch = Stopwatch::start();
        let mut starts: Vec<StepStart<'_>> = recycled(std::mem::take(&mut self.starts));
        let (settings, captured) = (&self.settings, self.captured_under_gravity);
        let pairs = self.instances.iter().zip(&self.newton.minimisations);
        starts.extend(pairs.map(|(instance, minimisation)| {
            tissue_start(settings, captured, instance, &minimisation.prescribed)
        }));
        self.potential
            .begin_step(&starts, &self.newton.active)
            .await?;
        self.starts = recycled(starts);
        timings.evaluation += watch.ms();
        Ok(())
    }

    /// Makes the iterates the new states and completes the reports.
    fn commit(&mut self) {
        let newton = &mut self.newton;
        for (i, instance) in self.instances.iter_mut().enumerate() {
            if !newton.active[i] {
                continue;
            }
            std::mem::swap(&mut instance.previous, &mut instance.state);
            instance.state.clone_from(&newton.iterates.states[i]);
            let frames = &instance.state.frames;
            let minimisation = &mut newton.minimisations[i];
            minimisation.report.max_joint_gap = joint_gap(self.skeleton.skeleton(), frames);
            let mass = self.skeleton.weighed_mass(instance.factors.gravity);
            minimisation.report.weight = mass * instance.gravity;
            let tracking = minimisation.skeleton.tracking().iter().map(|term| {
                let (force, torque) = term.load(frames);
                let bone = term.bone();
                Load {
                    bone,
                    force,
                    torque,
                }
            });
            let gradient = &minimisation.frame_gradient;
            let block = |b: usize| DVec3::from_slice(&gradient[3 * b..3 * b + 3]);
            let pins = instance.pins.iter().map(|pin| Load {
                bone: pin.bone,
                force: block(2 * pin.bone),
                torque: block(2 * pin.bone + 1),
            });
            minimisation.report.loads.extend(tracking.chain(pins));
            for target in &mut instance.targets {
                target.previous = target.frame;
            }
            for collider in &mut instance.colliders {
                collider.previous = collider.frame;
            }
        }
    }
}
