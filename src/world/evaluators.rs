//! All assets of a world as a step sees them: one list of members.
//!
//! What is asked of all is recorded for those on the GPU into one submission and sent, then answered by those on the CPU
//! while the device works, then read back at once.

use super::backend::Evaluator;
#[cfg(feature = "gpu")]
use super::gpu::Shared;
use crate::Result;
use crate::math::recycled;
use crate::model::State;
#[cfg(feature = "gpu")]
use crate::potential::GpuRecorder;
use crate::potential::{
    CpuPotential, Evaluation, EvaluationTimings, HessianForm, Potential, StepEnd, StepStart, Trial,
};
use crate::sim::Members;
use std::ops::Range;

/// What evaluates one asset's instances, which are consecutive members.
struct Batch {
    evaluator: Evaluator,
    members: Range<usize>,
    /// Memory of an energy difference: the asset's trials, which they are of all, and their results.
    trials: Vec<Trial<'static>>,
    places: Vec<usize>,
    differences: Vec<f64>,
    /// Those of the trials that the device is asked about.
    #[cfg(feature = "gpu")]
    asked: Range<usize>,
}

impl Batch {
    /// Finds the asset's own among all `trials`.
    fn find(&mut self, trials: &[Trial<'_>]) {
        self.places.clear();
        let own = |k: &usize| self.members.contains(&trials[*k].instance);
        self.places.extend((0..trials.len()).filter(own));
        self.differences.clear();
        self.differences.resize(self.places.len(), 0.0);
    }

    /// The asset's own from the `first` on, in memory to be given back.
    fn own_trials<'a>(&mut self, trials: &[Trial<'a>], first: usize) -> Vec<Trial<'a>> {
        let mut own: Vec<Trial<'a>> = recycled(std::mem::take(&mut self.trials));
        own.extend(self.places[first..].iter().map(|&k| Trial {
            instance: trials[k].instance - self.members.start,
            ..trials[k]
        }));
        own
    }
}

/// The evaluators of all assets, in one order with their batches.
#[derive(Default)]
pub(super) struct Evaluators {
    list: Vec<Batch>,
    /// The asset of each member.
    asset_of: Vec<usize>,
    /// Where any is on the GPU.
    #[cfg(feature = "gpu")]
    shared: Option<Shared>,
}

impl Evaluators {
    pub fn insert(&mut self, asset: usize, evaluator: Evaluator) {
        let batch = Batch {
            evaluator,
            members: 0..0,
            trials: Vec::new(),
            places: Vec::new(),
            differences: Vec::new(),
            #[cfg(feature = "gpu")]
            asked: 0..0,
        };
        self.list.insert(asset, batch);
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
        self.list.iter().map(|batch| &batch.evaluator)
    }

    /// Numbers the members anew, so many of each asset, and makes room for what is read back of them.
    pub fn number(&mut self, counts: impl Iterator<Item = usize>) -> Result<()> {
        #[cfg(feature = "gpu")]
        {
            let potentials = self.list.iter().filter_map(|batch| match &batch.evaluator {
                Evaluator::Cpu(_) => None,
                Evaluator::Gpu(potential) => Some(&**potential),
            });
            self.shared = Shared::with_room(self.shared.take(), potentials)?;
        }
        self.asset_of.clear();
        for (asset, (batch, count)) in self.list.iter_mut().zip(counts).enumerate() {
            let first = self.asset_of.len();
            batch.members = first..first + count;
            (self.asset_of).extend(std::iter::repeat_n(asset, count));
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
    list: &'a mut [Batch],
    wanted: &'a [bool],
) -> impl Iterator<Item = (&'a mut CpuPotential, Range<usize>)> {
    list.iter_mut().filter_map(|batch| {
        let range = batch.members.clone();
        let any = wanted[range.clone()].contains(&true);
        let potential = batch.evaluator.on_cpu().filter(|_| any)?;
        Some((potential, range))
    })
}

/// Those on the GPU of which any member is `wanted`, with their members.
#[cfg(feature = "gpu")]
fn on_gpu<'a>(
    list: &'a mut [Batch],
    wanted: &'a [bool],
) -> impl Iterator<Item = (&'a mut GpuRecorder, Range<usize>)> {
    list.iter_mut().filter_map(|batch| {
        let range = batch.members.clone();
        let any = wanted[range.clone()].contains(&true);
        let potential = batch.evaluator.on_gpu().filter(|_| any)?;
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
            let bytes = shared.read().await?;
            for (recorder, range) in on_gpu(&mut self.list, wanted) {
                let states = &states[range.clone()];
                recorder.finish_evaluate(&bytes, states, &mut out[range])?;
            }
        }
        Ok(())
    }

    async fn end_step(
        &mut self,
        states: &[State],
        wanted: &[bool],
        out: &mut [StepEnd],
    ) -> Result<()> {
        #[cfg(feature = "gpu")]
        if let Some(shared) = &mut self.shared {
            let submission = shared.begin();
            for (recorder, range) in on_gpu(&mut self.list, wanted) {
                let (states, wanted) = (&states[range.clone()], &wanted[range]);
                recorder.record_end_step(states, wanted, submission)?;
            }
            submission.flush();
        }
        for (potential, range) in on_cpu(&mut self.list, wanted) {
            let (states, wanted) = (&states[range.clone()], &wanted[range.clone()]);
            Potential::end_step(potential, states, wanted, &mut out[range]).await?;
        }
        #[cfg(feature = "gpu")]
        if let Some(shared) = &mut self.shared {
            let bytes = shared.read().await?;
            for (recorder, range) in on_gpu(&mut self.list, wanted) {
                recorder.finish_end_step(&bytes, &mut out[range])?;
            }
        }
        Ok(())
    }

    async fn energy_differences(&mut self, trials: &[Trial<'_>], out: &mut [f64]) -> Result<()> {
        self.list.iter_mut().for_each(|batch| batch.find(trials));
        #[cfg(feature = "gpu")]
        let mut more = self.record_differences(trials, true)?;
        for batch in &mut self.list {
            if batch.places.is_empty() || batch.evaluator.on_cpu().is_none() {
                continue;
            }
            let own = batch.own_trials(trials, 0);
            if let Some(potential) = batch.evaluator.on_cpu() {
                Potential::energy_differences(potential, &own, &mut batch.differences).await?;
            }
            batch.trials = recycled(own);
        }
        #[cfg(feature = "gpu")]
        while more {
            self.read_differences().await?;
            more = self.record_differences(trials, false)?;
        }
        for batch in &self.list {
            for (&k, difference) in batch.places.iter().zip(&batch.differences) {
                out[k] = *difference;
            }
        }
        Ok(())
    }

    /// Only submits on the GPU: who draws from there needs to wait for nothing.
    async fn pose_skin(&mut self, states: &[State], offsets: &[&[[f32; 3]]]) -> Result<()> {
        #[cfg(feature = "gpu")]
        if let Some(shared) = &mut self.shared {
            let submission = shared.begin();
            for batch in &mut self.list {
                let range = batch.members.clone();
                if let Some(potential) = batch.evaluator.on_gpu()
                    && !range.is_empty()
                {
                    let (states, offsets) = (&states[range.clone()], &offsets[range]);
                    let recorder = potential.recorder();
                    recorder.record_pose_skin(states, offsets, submission)?;
                }
            }
            submission.flush();
        }
        for batch in &mut self.list {
            let range = batch.members.clone();
            if let Some(potential) = batch.evaluator.on_cpu()
                && !range.is_empty()
            {
                let (states, offsets) = (&states[range.clone()], &offsets[range]);
                Potential::pose_skin(potential, states, offsets).await?;
            }
        }
        Ok(())
    }
}

#[cfg(feature = "gpu")]
impl Evaluators {
    /// Sends as many of the trials that are left (all at first) as there is room for; whether there are any.
    fn record_differences(&mut self, trials: &[Trial<'_>], first: bool) -> Result<bool> {
        let Some(shared) = &mut self.shared else {
            return Ok(false);
        };
        let submission = shared.begin();
        let mut any = false;
        for batch in &mut self.list {
            let done = if first { 0 } else { batch.asked.end };
            batch.asked = done..done;
            if done == batch.places.len() || batch.evaluator.on_gpu().is_none() {
                continue;
            }
            let own = batch.own_trials(trials, done);
            if let Some(potential) = batch.evaluator.on_gpu() {
                let recorder = potential.recorder();
                let count = recorder.record_energy_differences(&own, submission)?;
                batch.asked = done..done + count;
                any |= count > 0;
            }
            batch.trials = recycled(own);
        }
        submission.flush();
        Ok(any)
    }

    /// The answers to them.
    async fn read_differences(&mut self) -> Result<()> {
        let Some(shared) = &mut self.shared else {
            return Ok(());
        };
        let bytes = shared.read().await?;
        for batch in &mut self.list {
            if let Some(potential) = batch.evaluator.on_gpu()
                && !batch.asked.is_empty()
            {
                let out = &mut batch.differences[batch.asked.clone()];
                potential
                    .recorder()
                    .finish_energy_differences(&bytes, out)?;
            }
        }
        Ok(())
    }
}
