//! The incremental potential of a step that is not made, for who looks at it from outside: optimisers, plots, tests of a
//! solver of one's own.

use super::carried::carried_bones;
use super::instance::Instance;
use super::settings::Settings;
use super::skin_spring::SkinPulls;
use super::step_start::tissue_start;
use super::stepper::Physics;
use crate::Result;
use crate::model::{Avatar, Space, State};
use crate::potential::cpu::Exact;
use crate::potential::{
    BlockPattern, CpuPotential, Energies, Evaluation, HessianForm, Potential, StepEnd,
};
use crate::skeleton::{SkeletonEnergies, SkeletonModel, SkeletonPotential};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Energies of tissue and skeleton, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StepEnergies {
    /// The tissue's.
    pub tissue: Energies,
    /// The bones' own.
    pub skeleton: SkeletonEnergies,
}

impl StepEnergies {
    /// Their sum.
    pub fn total(&self) -> f64 {
        self.tissue.total() + self.skeleton.total()
    }
}

/// E(q) of an instance's next step, tissue and skeleton together, in f64: what [`Simulation`](super::Simulation) and
/// [`World`](crate::World) minimise. Nothing moves by it.
///
/// Derivatives are by the increments of [`State::moved`] at q. All frames have theirs here, those that pins prescribe as
/// well; [`StepPotential::fixed`] says which DoFs a step leaves alone.
pub struct StepPotential {
    tissue: Exact,
    skeleton: SkeletonPotential,
    pulls: SkinPulls,
    start: State,
    fixed: Vec<bool>,
}

impl StepPotential {
    /// E of the step of `settings.time_step` that `instance` of `avatar` would make next. A frame that a step would split
    /// ([`Settings::longest_step`]) is one step here.
    ///
    /// # Errors
    /// The avatar, the settings or the instance are unusable.
    pub fn new(avatar: Arc<Avatar>, instance: &Instance, settings: &Settings) -> Result<Self> {
        avatar.validate()?;
        settings.validate()?;
        instance.validate(&avatar.rest_state())?;
        let physics = Physics {
            skeleton: SkeletonModel::new(&avatar),
            captured_under_gravity: avatar.captured_under_gravity,
            waking: None,
            settings: *settings,
        };
        let mut fixed = vec![false; avatar.space().dofs()];
        let mut carried = Vec::new();
        carried_bones(&physics.skeleton, instance, &mut carried);
        let pinned = instance.pins.iter().map(|pin| pin.bone);
        for bone in pinned.chain(carried.iter().map(|c| c.bone)) {
            fixed[6 * bone..6 * bone + 6].fill(true);
        }
        let slots = avatar.coarse_handles()..avatar.handles.len();
        for slot in slots.skip(instance.awake.handles().len()) {
            let block = avatar.space().handle_block(slot);
            fixed[3 * block..3 * block + 3].fill(true);
        }
        let mut tissue = Exact(CpuPotential::new(avatar, 1)?);
        tissue.wake(0, &instance.awake)?;
        let start = tissue_start(settings, physics.captured_under_gravity, instance, &[]);
        pollster::block_on(tissue.begin_step(&[start], &[true]))?;
        let mut pulls = SkinPulls::default();
        let skeleton = physics.skeleton.skeleton();
        let (state, offsets) = (&instance.state, instance.pose_offsets.as_slice());
        pulls.restart(&instance.skin_springs, skeleton, state, offsets)?;
        Ok(Self {
            tissue,
            pulls,
            skeleton: physics.skeleton_potential(instance),
            start: instance.state.clone(),
            fixed,
        })
    }

    /// qⁿ, where the step starts.
    pub fn start(&self) -> &State {
        &self.start
    }

    /// The numbering of the DoFs.
    pub fn space(&self) -> Space {
        self.tissue.space()
    }

    /// Which blocks of the Hessian there are.
    pub fn pattern(&self) -> &BlockPattern {
        self.tissue.pattern()
    }

    /// Which DoFs a step leaves to what prescribes them: six of each bone that is pinned, or carried by its parent.
    pub fn fixed(&self) -> &[bool] {
        &self.fixed
    }

    /// E(q) − E(qⁿ), term by term.
    ///
    /// # Errors
    /// A state of another space, or one that is not finite.
    pub fn energies(&mut self, state: &State) -> Result<StepEnergies> {
        let mut out = [StepEnd::default()];
        let states = std::slice::from_ref(state);
        pollster::block_on(self.tissue.end_step(states, &[true], &mut out))?;
        let [end] = out;
        Ok(self.with_skeleton(end.energies, state))
    }

    /// E(q) − E(qⁿ), with ∂E/∂q and the Hessian of this form written into `out`, those of the skeleton included; the
    /// energies in `out` are the tissue's.
    ///
    /// # Errors
    /// As [`StepPotential::energies`].
    pub fn evaluate(
        &mut self,
        state: &State,
        form: HessianForm,
        out: &mut Evaluation,
    ) -> Result<StepEnergies> {
        let (states, active) = (std::slice::from_ref(state), &[true]);
        let outs = std::slice::from_mut(out);
        pollster::block_on(async {
            match form {
                HessianForm::Exact => self.tissue.evaluate(states, active, outs).await,
                HessianForm::Solver => self.tissue.0.evaluate(states, active, outs).await,
            }
        })?;
        let (frames, pattern) = (&state.frames, self.tissue.pattern());
        let (gradient, hessian) = (&mut out.gradient, &mut out.hessian);
        (self.skeleton).add_derivatives(frames, gradient, hessian, pattern);
        (self.pulls).add_derivatives(state, gradient, hessian, pattern);
        if form == HessianForm::Exact {
            self.skeleton.add_geometric(frames, hessian, pattern);
            self.pulls.add_geometric(state, hessian, pattern);
        }
        Ok(self.with_skeleton(out.energies, state))
    }

    fn with_skeleton(&self, tissue: Energies, state: &State) -> StepEnergies {
        let mut skeleton = (self.skeleton).difference(&self.start.frames, &state.frames);
        skeleton.tracking += self.pulls.difference(&self.start, state);
        StepEnergies { tissue, skeleton }
    }
}
