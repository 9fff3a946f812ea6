//! All assets of a world as a step sees them: one list of members.
//!
//! What is asked of all is recorded for those on the GPU into one submission and sent, then answered by those on the CPU
//! while the device works, then read back at once.

use super::backend::Evaluator;
#[cfg(feature = "gpu")]
use super::gpu::Shared;
#[cfg(feature = "gpu")]
use super::late_ends::LateEnds;
use super::trials::OwnTrials;
use crate::Result;
use crate::model::State;
#[cfg(feature = "gpu")]
use crate::potential::GpuRecorder;
use crate::potential::{
    CpuPotential, Difference, Evaluation, EvaluationTimings, HessianForm, Potential, PreviousSkin,
    StepEnd, StepStart, Trial,
};
use crate::sim::Members;
use std::ops::Range;

/// What evaluates one asset's instances, which are consecutive members.
pub(super) struct AssetEvaluator {
    pub evaluator: Evaluator,
    pub members: Range<usize>,
    pub trials: OwnTrials,
    #[cfg(feature = "gpu")]
    pub ends: LateEnds,
}

/// The evaluators of all assets, in the world's order.
#[derive(Default)]
pub(super) struct Evaluators {
    pub(super) list: Vec<AssetEvaluator>,
    /// The asset of each member.
    asset_of: Vec<usize>,
    /// Where any is on the GPU.
    #[cfg(feature = "gpu")]
    pub(super) shared: Option<Shared>,
}

impl Evaluators {
    pub fn insert(&mut self, asset: usize, evaluator: Evaluator) {
        let evaluator = AssetEvaluator {
            evaluator,
            members: 0..0,
            trials: OwnTrials::default(),
            #[cfg(feature = "gpu")]
            ends: LateEnds::default(),
        };
        self.list.insert(asset, evaluator);
    }

    pub fn replace(&mut self, asset: usize, evaluator: Evaluator) {
        self.list[asset].evaluator = evaluator;
    }

    pub fn remove(&mut self, asset: usize) {
        self.list.remove(asset);
    }

    pub fn get(&self, asset: usize) -> &Evaluator {
        &self.list[asset].evaluator
    }

    pub fn get_mut(&mut self, asset: usize) -> &mut Evaluator {
        &mut self.list[asset].evaluator
    }

    pub fn iter(&self) -> impl Iterator<Item = &Evaluator> {
        self.list.iter().map(|asset| &asset.evaluator)
    }

    /// Numbers the members anew, so many of each asset, and makes room for what is read back of them.
    pub fn number(&mut self, counts: impl Iterator<Item = usize>) -> Result<()> {
        #[cfg(feature = "gpu")]
        {
            let potentials = self.list.iter().filter_map(|asset| match &asset.evaluator {
                Evaluator::Cpu(_) => None,
                Evaluator::Gpu(potential) => Some(&**potential),
            });
            self.shared = Shared::with_room(self.shared.take(), potentials)?;
        }
        self.asset_of.clear();
        for (i, (asset, count)) in self.list.iter_mut().zip(counts).enumerate() {
            let first = self.asset_of.len();
            asset.members = first..first + count;
            #[cfg(feature = "gpu")]
            asset.ends.set_count(count);
            (self.asset_of).extend(std::iter::repeat_n(i, count));
        }
        Ok(())
    }

    /// Time that all spent since the step began.
    pub fn timings(&self) -> EvaluationTimings {
        let mut sum = EvaluationTimings::default();
        for evaluator in self.iter() {
            let timings = evaluator.timings();
            sum.force += timings.force;
            sum.hessian += timings.hessian;
            sum.readback += timings.readback;
        }
        #[cfg(feature = "gpu")]
        if let Some(shared) = &self.shared {
            sum.readback += shared.readback;
        }
        sum
    }

    /// Submissions and readbacks so far, of the evaluators on the GPU as they are now.
    #[cfg(feature = "gpu")]
    pub fn traffic(&self) -> [u64; 2] {
        (self.shared.as_ref()).map_or([0; 2], |shared| shared.submission.traffic())
    }
}

/// Those on the CPU of which any member is `wanted`, with their members.
fn on_cpu<'a>(
    list: &'a mut [AssetEvaluator],
    wanted: &'a [bool],
) -> impl Iterator<Item = (&'a mut CpuPotential, Range<usize>)> {
    list.iter_mut().filter_map(|asset| {
        let range = asset.members.clone();
        let any = wanted[range.clone()].contains(&true);
        let potential = asset.evaluator.on_cpu().filter(|_| any)?;
        Some((potential, range))
    })
}

/// Those on the GPU of which any member is `wanted`, with their members.
#[cfg(feature = "gpu")]
fn on_gpu<'a>(
    list: &'a mut [AssetEvaluator],
    wanted: &'a [bool],
) -> impl Iterator<Item = (&'a mut GpuRecorder, Range<usize>)> {
    list.iter_mut().filter_map(|asset| {
        let range = asset.members.clone();
        let any = wanted[range.clone()].contains(&true);
        let potential = asset.evaluator.on_gpu().filter(|_| any)?;
        Some((potential.recorder(), range))
    })
}

impl Members for Evaluators {
    fn hessian_form(&self, member: usize) -> HessianForm {
        self.get(self.asset_of[member]).hessian_form()
    }

    /// Only records on the GPU: the first evaluation sends it with itself.
    async fn begin_step(&mut self, starts: &[StepStart<'_>], active: &[bool]) -> Result<()> {
        #[cfg(feature = "gpu")]
        if let Some(shared) = &mut self.shared {
            shared.readback = 0.0;
            let submission = shared.begin();
            for (recorder, range) in on_gpu(&mut self.list, active) {
                let (starts, active) = (&starts[range.clone()], &active[range]);
                recorder.record_begin_step(starts, active, submission)?;
            }
        }
        for (potential, range) in on_cpu(&mut self.list, active) {
            let (starts, active) = (&starts[range.clone()], &active[range]);
            Potential::begin_step(potential, starts, active).await?;
        }
        Ok(())
    }

    async fn evaluate(
        &mut self,
        states: &[State],
        wanted: &[bool],
        out: &mut [Evaluation],
    ) -> Result<()> {
        #[cfg(feature = "gpu")]
        if let Some(shared) = &mut self.shared {
            let submission = shared.begin();
            for (recorder, range) in on_gpu(&mut self.list, wanted) {
                let (states, wanted) = (&states[range.clone()], &wanted[range]);
                recorder.record_evaluate(states, wanted, submission)?;
            }
            submission.flush();
        }
        for (potential, range) in on_cpu(&mut self.list, wanted) {
            let (states, wanted) = (&states[range.clone()], &wanted[range.clone()]);
            Potential::evaluate(potential, states, wanted, &mut out[range]).await?;
        }
        #[cfg(feature = "gpu")]
        if let Some(shared) = &mut self.shared {
            let bytes = shared.read(&mut self.list).await?;
            for (recorder, range) in on_gpu(&mut self.list, wanted) {
                let states = &states[range.clone()];
                recorder.finish_evaluate(&bytes, states, &mut out[range])?;
            }
        }
        Ok(())
    }

    /// Waits for nothing on the GPU where all that is asked of it may be late and is known.
    async fn end_step(
        &mut self,
        states: &[State],
        wanted: &[bool],
        out: &mut [StepEnd],
        late: &mut [bool],
    ) -> Result<()> {
        #[cfg(feature = "gpu")]
        let waits = self.record_end_step(states, wanted, late)?;
        for (potential, range) in on_cpu(&mut self.list, wanted) {
            late[range.clone()].fill(false);
            let (states, wanted) = (&states[range.clone()], &wanted[range.clone()]);
            Potential::end_step(potential, states, wanted, &mut out[range]).await?;
        }
        #[cfg(feature = "gpu")]
        self.tell_ends(wanted, waits, out, late).await?;
        Ok(())
    }

    async fn energy_differences(
        &mut self,
        trials: &[Trial<'_>],
        out: &mut [Difference],
    ) -> Result<()> {
        self.compare(trials, out).await
    }

    /// Only submits on the GPU: who draws from there needs to wait for nothing.
    async fn pose_skin(
        &mut self,
        states: &[State],
        offsets: &[&[[f32; 3]]],
        previous: &[PreviousSkin],
    ) -> Result<()> {
        #[cfg(feature = "gpu")]
        if let Some(shared) = &mut self.shared {
            let submission = shared.begin();
            for asset in &mut self.list {
                let range = asset.members.clone();
                if let Some(potential) = asset.evaluator.on_gpu()
                    && !range.is_empty()
                {
                    let (states, offsets) = (&states[range.clone()], &offsets[range.clone()]);
                    let recorder = potential.recorder();
                    recorder.record_pose_skin(states, offsets, &previous[range], submission)?;
                }
            }
            submission.flush();
        }
        for asset in &mut self.list {
            let range = asset.members.clone();
            if let Some(potential) = asset.evaluator.on_cpu()
                && !range.is_empty()
            {
                let (states, offsets) = (&states[range.clone()], &offsets[range.clone()]);
                Potential::pose_skin(potential, states, offsets, &previous[range]).await?;
            }
        }
        Ok(())
    }
}
