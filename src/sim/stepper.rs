//! A step of members of any assets, from their instances to their instances.

use super::carried::{carried_bones, carry};
use super::groups::Link;
use super::instance::Instance;
use super::iteration::Observer;
use super::members::Members;
use super::minimisation::Minimisation;
use super::newton::Newton;
use super::prediction::{carry_on, fall_back, predict};
use super::report::{InstanceReport, Load, Timings};
use super::settings::Settings;
use super::solvers::{Solvers, Systems};
use super::step_end::StepEnds;
use super::step_start::{skeleton_start, tissue_start};
use super::waking::Waking;
use crate::math::{Stopwatch, par_members, recycled};
use crate::model::State;
use crate::potential::{PreviousSkin, StepStart};
use crate::skeleton::{SkeletonModel, SkeletonPotential, joint_gap};
use crate::{Error, Result};
use glam::DVec3;
use std::borrow::{Borrow, BorrowMut};
use std::ops::Range;

/// What steps the instances of an asset, all constant.
#[derive(Clone, Debug)]
pub(crate) struct Physics {
    /// The bones' own terms.
    pub skeleton: SkeletonModel,
    /// Which fine handles wake; none of an avatar without slots for them.
    pub waking: Option<Waking>,
    /// Whether the rest shape already sags, see [`Avatar::captured_under_gravity`](crate::model::Avatar).
    pub captured_under_gravity: bool,
    /// What stays the same through its steps.
    pub settings: Settings,
}

impl Physics {
    /// The bones' own terms of the next step of `instance`.
    pub fn skeleton_potential(&self, instance: &Instance) -> SkeletonPotential {
        let start = skeleton_start(&self.settings, instance);
        SkeletonPotential::new(&self.skeleton, &start)
    }
}

/// The memory of steps of a list of members. The instances of an asset are consecutive members.
pub(crate) struct Stepper {
    newton: Newton,
    ends: StepEnds,
    /// Memory of the starts of a step.
    starts: Vec<StepStart<'static>>,
    /// Memory of the offsets with which skins are posed.
    offsets: Vec<&'static [[f32; 3]]>,
    /// Memory of whose ends are asked for.
    pinned: Vec<bool>,
    /// Memory of what the previous skins are after the step.
    previous_skins: Vec<PreviousSkin>,
}

impl Stepper {
    /// Room for `members` of assets that have `solvers`; of each asset there are so many as `counts` says.
    pub fn new<'a>(
        members: impl Iterator<Item = (&'a Physics, &'a Instance)>,
        solvers: Vec<Solvers>,
        counts: impl Iterator<Item = usize>,
    ) -> Self {
        let of_asset = |(asset, count)| std::iter::repeat_n(asset, count);
        let systems = Systems::new(solvers, counts.enumerate().flat_map(of_asset).collect());
        let minimisation = |(physics, instance): (&Physics, &Instance)| {
            let skeleton = physics.skeleton_potential(instance);
            Minimisation::new(skeleton, instance.state.clone())
        };
        let minimisations: Vec<_> = members.map(minimisation).collect();
        Self {
            ends: StepEnds::new(minimisations.iter().map(|m| m.current.frames.len())),
            newton: Newton::new(minimisations, systems),
            starts: Vec::new(),
            offsets: Vec::new(),
            pinned: Vec::new(),
            previous_skins: Vec::new(),
        }
    }

    /// From now on these links join members.
    pub fn join(&mut self, links: &[Link]) {
        let count = self.newton.minimisations.len();
        self.newton.groups.set(count, links);
    }

    /// Checks and predicts the `instances` of an asset, which are the members of `range`.
    pub fn begin(
        &mut self,
        range: Range<usize>,
        physics: &Physics,
        instances: &[impl Borrow<Instance> + Sync],
    ) -> Result<()> {
        let newton = &mut self.newton;
        for (active, instance) in newton.active[range.clone()].iter_mut().zip(instances) {
            *active = instance.borrow().active;
        }
        let minimisations = &mut newton.minimisations[range.clone()];
        let parts = (
            &mut minimisations[..],
            &mut newton.iterates.states[range.clone()],
            &mut newton.others.states[range.clone()],
            &mut newton.fallbacks[range.clone()],
        );
        par_members(
            range.len(),
            parts,
            |i, (minimisation, iterate, carried, fallback)| {
                let instance: &Instance = instances[i].borrow();
                minimisation.report.reset();
                if !instance.active {
                    iterate.clone_from(&instance.state);
                    return;
                }
                minimisation.solved = instance.validate(&minimisation.current);
                if minimisation.solved.is_err() {
                    return;
                }
                let start = skeleton_start(&physics.settings, instance);
                minimisation.skeleton.restart(&physics.skeleton, &start);
                let skeleton = physics.skeleton.skeleton();
                let (state, offsets) = (&instance.state, instance.pose_offsets.as_slice());
                let springs = &instance.skin_springs;
                minimisation.solved =
                    (minimisation.pulls).restart(springs, skeleton, state, offsets);
                minimisation.current.clone_from(&instance.state);
                minimisation.may_touch = !instance.colliders.is_empty();
                fall_back(skeleton, instance, fallback);
                predict(skeleton, instance, &start.inertia, iterate);
                carry_on(instance, iterate, carried);
                minimisation.fixed.fill(false);
                if let Some(waking) = &physics.waking {
                    minimisation.hold_sleeping(waking.first_slot(), instance);
                }
                minimisation.prescribed.fill(false);
                carried_bones(&physics.skeleton, instance, &mut minimisation.carried);
                for start in [iterate, carried, fallback] {
                    carry(&minimisation.carried, start);
                }
                for pin in &instance.pins {
                    minimisation.prescribe(pin.bone);
                }
                for k in 0..minimisation.carried.len() {
                    minimisation.prescribe(minimisation.carried[k].bone);
                }
            },
        );
        let mut solved = minimisations.iter_mut().map(|m| &mut m.solved);
        solved.try_for_each(|solved| std::mem::replace(solved, Ok(())))
    }

    /// Holds frame `frame` of a member where it is in this step.
    pub fn hold(&mut self, member: usize, frame: usize) {
        self.newton.minimisations[member].prescribe(frame);
    }

    /// The next report on a member is not of an earlier step.
    pub fn forget_end(&mut self, member: usize) {
        self.ends.forget(member);
    }

    /// Gives a link's frame the place of its body, in prediction and fall-back.
    pub fn follow_body(&mut self, link: &Link) {
        let newton = &mut self.newton;
        for states in [
            &mut newton.iterates.states,
            &mut newton.others.states,
            &mut newton.fallbacks,
        ] {
            let body = states[link.body].frames[0];
            states[link.member].frames[link.frame] = body;
        }
    }

    /// Minimises from what [`Stepper::begin`] left, lets spring bones swing, and poses the skin of the result. `each` is
    /// every member in order. Only the `last` step of a frame reports on its end and poses the skin.
    pub async fn minimise<M: Members>(
        &mut self,
        members: &mut M,
        each: &[(&Physics, &Instance)],
        last: bool,
        timings: &mut Timings,
        observer: &mut Observer<'_>,
    ) -> Result<()> {
        let watch = Stopwatch::start();
        let mut starts: Vec<StepStart<'_>> = recycled(std::mem::take(&mut self.starts));
        let mut offsets: Vec<&[[f32; 3]]> = recycled(std::mem::take(&mut self.offsets));
        let newton = &mut self.newton;
        let mut mode = None;
        self.pinned.clear();
        self.previous_skins.clear();
        let pairs = each.iter().zip(&newton.minimisations);
        starts.extend(pairs.map(|(&(physics, instance), minimisation)| {
            let settings = &physics.settings;
            mode = Some(settings.solver);
            offsets.push(instance.pose_offsets.as_slice());
            (self.pinned).push(last && (settings.report_at_end || !instance.pins.is_empty()));
            (self.previous_skins).push(instance.previous_skin());
            let captured = physics.captured_under_gravity;
            tissue_start(settings, captured, instance, &minimisation.prescribed)
        }));
        members.begin_step(&starts, &newton.active).await?;
        self.starts = recycled(starts);
        timings.evaluation += watch.ms();
        let Some(mode) = mode else {
            return Ok(());
        };
        newton.minimise(members, mode, timings, observer).await?;
        let watch = Stopwatch::start();
        let active = &newton.active;
        let parts = (
            &mut newton.minimisations[..],
            &mut newton.iterates.states[..],
        );
        par_members(each.len(), parts, |i, (minimisation, state)| {
            let (physics, instance) = each[i];
            let carried = &minimisation.carried;
            if active[i] && carried.iter().any(|of| of.spring.is_some()) {
                let (springs, h) = (physics.skeleton.springs(), physics.settings.time_step);
                (minimisation.swing).step(springs, carried, instance, h, state);
            } else if active[i] {
                carry(carried, state);
            }
        });
        timings.skeleton += watch.ms();
        for (state, active) in newton.iterates.states.iter().zip(&newton.active) {
            if *active && !state.is_finite() {
                return Err(Error::NotFinite { quantity: "state" });
            }
        }
        if !last {
            self.offsets = recycled(offsets);
            return Ok(());
        }
        let watch = Stopwatch::start();
        let wanted = self.pinned.iter().copied();
        self.ends.report(members, newton, wanted).await?;
        timings.evaluation += watch.ms();
        let watch = Stopwatch::start();
        let states = &newton.iterates.states;
        let posed = members
            .pose_skin(states, &offsets, &self.previous_skins)
            .await;
        self.offsets = recycled(offsets);
        timings.skin = watch.ms();
        posed?;
        self.ends.keep();
        Ok(())
    }

    /// Makes the iterates the new states of the `instances` of an asset, which are the members of `range`, and completes
    /// the reports.
    pub fn commit(
        &mut self,
        range: Range<usize>,
        physics: &Physics,
        instances: &mut [impl BorrowMut<Instance> + Send],
        last: bool,
    ) {
        let newton = &mut self.newton;
        let (states, active) = (&newton.iterates.states, &newton.active);
        let parts = (&mut newton.minimisations[range.clone()], instances);
        par_members(range.len(), parts, |i, (minimisation, instance)| {
            let member = range.start + i;
            let instance: &mut Instance = instance.borrow_mut();
            instance.was_put &= !last;
            if active[member] {
                commit(minimisation, &states[member], physics, instance, last);
            }
        });
    }

    /// The force that a link's member exerts on its body in the state that its report is of, N; none where that is not the
    /// end of a step.
    pub fn push(&self, link: &Link) -> Option<DVec3> {
        let gradient = &self.newton.minimisations[link.member].frame_gradient;
        let asked = self.newton.active[link.member] && self.pinned[link.member];
        asked.then(|| -DVec3::from_slice(&gradient[6 * link.frame..6 * link.frame + 3]))
    }

    /// Exchanges the report of a member for the memory of an older one.
    pub fn swap_report(&mut self, member: usize, report: &mut InstanceReport) {
        std::mem::swap(report, &mut self.newton.minimisations[member].report);
    }
}

/// Makes `state` the new state of an active instance and completes its report on the `last` step of a frame.
fn commit(
    minimisation: &mut Minimisation,
    state: &State,
    physics: &Physics,
    instance: &mut Instance,
    last: bool,
) {
    let (integrator, time_step) = (physics.settings.integrator, physics.settings.time_step);
    (instance.history).advance(&instance.state, integrator, time_step);
    instance.state.clone_from(state);
    minimisation.swing.keep_velocities(
        physics.skeleton.springs(),
        &minimisation.carried,
        time_step,
        &instance.state,
        &mut instance.history.states_mut()[0],
    );
    if last {
        report(minimisation, physics, instance);
    }
    for target in &mut instance.targets {
        target.advance();
    }
    for collider in &mut instance.colliders {
        collider.previous = collider.frame;
    }
}

/// Completes the report on a step that has ended.
fn report(minimisation: &mut Minimisation, physics: &Physics, instance: &Instance) {
    let frames = &instance.state.frames;
    let report = &mut minimisation.report;
    report.max_joint_gap = joint_gap(physics.skeleton.skeleton(), frames);
    report.weight = physics.skeleton.weighed_mass(instance.factors.gravity) * instance.gravity;
    let loads = minimisation.skeleton.target_loads(frames);
    let tracking = loads.map(|(bone, force, torque)| Load {
        bone,
        force,
        torque,
    });
    let gradient = &minimisation.frame_gradient;
    let block = |b: usize| DVec3::from_slice(&gradient[3 * b..3 * b + 3]);
    let pins = instance.pins.iter().map(|pin| Load {
        bone: pin.bone,
        force: block(2 * pin.bone),
        torque: block(2 * pin.bone + 1),
    });
    report.loads.extend(tracking.chain(pins));
}
