//! The f64 evaluation of the potential: the twin of the kernels, and the fallback where there is no GPU.
//!
//! A stage is one file of plain functions of one point, named as its kernel; [`CpuPotential`] runs them
//! over all points, in parallel and with the same bits whatever the number of threads. The basis is a
//! trait ([`Basis`]), of which the avatar's scalar one is the plain case.

mod asset;
mod basis;
mod begin_step;
pub mod compact;
pub mod contact;
pub(crate) mod contact_forces;
mod cubature;
mod dense_hessian;
pub mod displacement;
pub mod elasticity;
pub mod energy;
mod energy_differences;
mod evaluate;
mod evaluate_points;
mod exact;
mod fine_skin;
pub mod friction;
pub mod geometric;
pub mod gradient;
pub mod hessian;
mod incidence;
pub mod inertial_target;
mod mechanics;
mod min_det_f;
mod motion;
pub mod normals;
pub mod point_hessian;
mod point_start;
mod points;
pub mod pose_blend;
mod pose_columns;
mod pose_skin;
mod posed_skin;
pub mod select;
pub mod skin;
mod woken;

pub use crate::potential::HessianForm;
pub use basis::{Basis, GeneralBasis, Mixed};
pub use exact::Exact;
pub use fine_skin::FineSkin;
pub use incidence::Incidence;
pub use mechanics::{Mechanics, mechanics};
pub use min_det_f::{min_det_f, min_det_f_at_nodes};
pub use motion::Motion;
pub use points::Points;
pub use posed_skin::{posed_skin, skin_displacement, unposed_skin};

use crate::Result;
use crate::math::{Rows, Stopwatch, in_pool, par_each, par_split};
use crate::model::{Avatar, Awake, BasisEntry, Space, State};
use crate::potential::checks::Checks;
use crate::potential::{
    BlockPattern, Difference, Evaluation, EvaluationTimings, Potential, PreviousSkin, StepEnd,
    StepStart, Trial,
};
use asset::Asset;
use evaluate::Instance;
use glam::DVec3;
use std::sync::Arc;

/// The potential of a batch of avatars on the CPU.
pub struct CpuPotential<B: Basis = BasisEntry> {
    asset: Asset<B>,
    checks: Checks,
    instances: Vec<Instance>,
}

impl CpuPotential {
    /// Evaluates `instances` avatars of one asset; any number of contacts may be active.
    ///
    /// # Errors
    /// Where the avatar is not valid or a point names a bone or a handle twice.
    pub fn new(avatar: Arc<Avatar>, instances: usize) -> Result<Self> {
        let (cubature, skin) = (&avatar.cubature.basis.clone(), &avatar.skin.basis.clone());
        Self::with_basis(avatar, cubature, skin, instances)
    }
}

impl<B: Basis> CpuPotential<B> {
    /// [`CpuPotential::new`] with another basis than the avatar's own: one row for each cubature point and
    /// each skin vertex.
    ///
    /// # Errors
    /// As [`CpuPotential::new`].
    pub fn with_basis(
        avatar: Arc<Avatar>,
        cubature: &Rows<B>,
        skin: &Rows<B>,
        instances: usize,
    ) -> Result<Self> {
        let asset = Asset::new(avatar, cubature, skin)?;
        Ok(Self {
            checks: Checks::new(&asset.avatar, instances),
            instances: (0..instances).map(|_| Instance::new(&asset)).collect(),
            asset,
        })
    }

    /// Whether `block` is a prescribed frame's in the step that `instance` has begun.
    fn is_prescribed(&self, instance: usize, block: usize) -> bool {
        point_hessian::is_prescribed(&self.instances[instance].step.prescribed, block)
    }

    /// Positions (m, world) of the posed skin of the step before.
    pub(crate) async fn read_previous_skin(
        &self,
        instance: usize,
        positions: &mut Vec<DVec3>,
    ) -> Result<()> {
        self.checks.instance(instance)?;
        positions.clone_from(&self.instances[instance].posed_skin.previous);
        Ok(())
    }

    fn has_begun(&self, instance: usize) -> bool {
        self.instances[instance].step.inertial_step > 0.0
    }
}

impl<B: Basis> Potential for CpuPotential<B> {
    fn name(&self) -> String {
        "cpu".into()
    }

    fn space(&self) -> Space {
        self.asset.space
    }

    fn pattern(&self) -> &BlockPattern {
        &self.asset.pattern
    }

    fn instances(&self) -> usize {
        self.instances.len()
    }

    fn timings(&self) -> EvaluationTimings {
        let mut sum = EvaluationTimings::default();
        for instance in &self.instances {
            sum.force += instance.timings.force;
            sum.hessian += instance.timings.hessian;
        }
        sum
    }

    fn wake(&mut self, instance: usize, awake: &Awake) -> Result<()> {
        self.checks.instance(instance)?;
        let (asset, instance) = (&self.asset, &mut self.instances[instance]);
        if instance.woken.is(awake) {
            return Ok(());
        }
        awake.validate(&asset.avatar)?;
        instance.step.fine_skin.set(&asset.avatar, awake);
        instance.woken.set(asset, awake);
        Ok(())
    }

    async fn begin_step(&mut self, starts: &[StepStart<'_>], active: &[bool]) -> Result<()> {
        self.checks.starts(starts, active)?;
        let asset = &self.asset;
        in_pool(|| {
            par_each(&mut self.instances, 1, |i, instance| {
                instance.timings = EvaluationTimings::default();
                if active[i] {
                    instance.begin_step(asset, &starts[i]);
                }
            });
        });
        Ok(())
    }

    async fn evaluate(
        &mut self,
        states: &[State],
        active: &[bool],
        out: &mut [Evaluation],
    ) -> Result<()> {
        self.checks
            .states(states, active, out.len(), |i| self.has_begun(i))?;
        let asset = &self.asset;
        in_pool(|| {
            let parts = (&mut self.instances[..], &mut *out);
            par_split(states.len(), 1, parts, |i, (instance, out)| {
                if active[i] {
                    instance.evaluate(asset, &states[i], out);
                }
            });
        });
        for i in (0..states.len()).filter(|&i| active[i]) {
            Instance::check(&out[i].energies, &out[i].gradient)?;
        }
        Ok(())
    }

    async fn end_step(
        &mut self,
        states: &[State],
        wanted: &[bool],
        out: &mut [StepEnd],
    ) -> Result<()> {
        self.checks
            .states(states, wanted, out.len(), |i| self.has_begun(i))?;
        let asset = &self.asset;
        in_pool(|| {
            let parts = (&mut self.instances[..], &mut *out);
            par_split(states.len(), 1, parts, |i, (instance, out)| {
                if wanted[i] {
                    instance.end_step(asset, &states[i], out);
                }
            });
        });
        for i in (0..states.len()).filter(|&i| wanted[i]) {
            Instance::check(&out[i].energies, &out[i].frame_gradient)?;
        }
        Ok(())
    }

    async fn energy_differences(
        &mut self,
        trials: &[Trial<'_>],
        out: &mut [Difference],
    ) -> Result<()> {
        self.checks
            .trials(trials, out.len(), |i| self.has_begun(i))?;
        let (asset, instances) = (&self.asset, &mut self.instances);
        in_pool(|| {
            for (trial, out) in trials.iter().zip(&mut *out) {
                let watch = Stopwatch::start();
                let instance = &mut instances[trial.instance];
                let (energies, foresight) = instance.difference(asset, trial.base, trial.state);
                *out = Difference {
                    energy: energies.total(),
                    unforeseen_force: foresight.unforeseen,
                    pressing_force: foresight.pressing,
                };
                instance.timings.force += watch.ms();
            }
        });
        Ok(())
    }

    async fn pose_skin(
        &mut self,
        states: &[State],
        offsets: &[&[[f32; 3]]],
        previous: &[PreviousSkin],
    ) -> Result<()> {
        self.checks.poses(states, offsets, previous)?;
        let asset = &self.asset;
        in_pool(|| {
            par_each(&mut self.instances, 1, |i, instance| {
                let offsets = offsets.get(i).copied().unwrap_or_default();
                let previous = previous.get(i).copied().unwrap_or(PreviousSkin::Kept);
                let skin = &mut instance.posed_skin;
                let posed = (asset, &instance.step.fine_skin);
                skin.pose(posed, &states[i], offsets, previous);
            });
        });
        Ok(())
    }

    async fn read_skin(
        &mut self,
        instance: usize,
        positions: &mut Vec<DVec3>,
        normals: &mut Vec<DVec3>,
    ) -> Result<()> {
        self.checks.instance(instance)?;
        let posed_skin = &self.instances[instance].posed_skin;
        positions.clone_from(&posed_skin.positions);
        normals.clone_from(&posed_skin.normals);
        Ok(())
    }

    async fn read_contacts(
        &mut self,
        instance: usize,
        state: &State,
        forces: &mut Vec<DVec3>,
        pressures: &mut Vec<f64>,
    ) -> Result<()> {
        self.checks.instance(instance)?;
        self.checks.begun(instance, self.has_begun(instance))?;
        self.checks.state(state)?;
        let (asset, instance) = (&self.asset, &mut self.instances[instance]);
        in_pool(|| instance.contact_forces(asset, state, forces, pressures));
        Ok(())
    }
}
