//! All assets of a world as a step sees them: one list of members.

use super::backend::Evaluator;
use crate::Result;
use crate::math::recycled;
use crate::model::State;
use crate::potential::{Evaluation, HessianForm, StepEnd, StepStart, Trial};
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
}

/// The evaluators of all assets, in one order with their batches.
#[derive(Default)]
pub(super) struct Evaluators {
    list: Vec<Batch>,
    /// The asset of each member.
    asset_of: Vec<usize>,
}

impl Evaluators {
    pub fn insert(&mut self, asset: usize, evaluator: Evaluator) {
        let batch = Batch {
            evaluator,
            members: 0..0,
            trials: Vec::new(),
            places: Vec::new(),
            differences: Vec::new(),
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

    /// Numbers the members anew: so many of each asset.
    pub fn number(&mut self, counts: impl Iterator<Item = usize>) {
        self.asset_of.clear();
        for (asset, (batch, count)) in self.list.iter_mut().zip(counts).enumerate() {
            let first = self.asset_of.len();
            batch.members = first..first + count;
            (self.asset_of).extend(std::iter::repeat_n(asset, count));
        }
    }
}

impl Members for Evaluators {
    fn hessian_form(&self, member: usize) -> HessianForm {
        self.get(self.asset_of[member]).hessian_form()
    }

    async fn begin_step(&mut self, starts: &[StepStart<'_>], active: &[bool]) -> Result<()> {
        for batch in &mut self.list {
            let range = batch.members.clone();
            let (starts, active) = (&starts[range.clone()], &active[range]);
            if active.contains(&true) {
                batch.evaluator.begin_step(starts, active).await?;
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
            let range = batch.members.clone();
            let (states, wanted) = (&states[range.clone()], &wanted[range.clone()]);
            if wanted.contains(&true) {
                (batch.evaluator)
                    .evaluate(states, wanted, &mut out[range])
                    .await?;
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
        for batch in &mut self.list {
            let range = batch.members.clone();
            let (states, wanted) = (&states[range.clone()], &wanted[range.clone()]);
            if wanted.contains(&true) {
                (batch.evaluator)
                    .end_step(states, wanted, &mut out[range])
                    .await?;
            }
        }
        Ok(())
    }

    async fn energy_differences(&mut self, trials: &[Trial<'_>], out: &mut [f64]) -> Result<()> {
        for batch in &mut self.list {
            let mut of_asset: Vec<Trial<'_>> = recycled(std::mem::take(&mut batch.trials));
            batch.places.clear();
            for (k, trial) in trials.iter().enumerate() {
                if batch.members.contains(&trial.instance) {
                    of_asset.push(Trial {
                        instance: trial.instance - batch.members.start,
                        ..*trial
                    });
                    batch.places.push(k);
                }
            }
            batch.differences.resize(of_asset.len(), 0.0);
            if !of_asset.is_empty() {
                let out = &mut batch.differences;
                batch.evaluator.energy_differences(&of_asset, out).await?;
            }
            for (&k, difference) in batch.places.iter().zip(&batch.differences) {
                out[k] = *difference;
            }
            batch.trials = recycled(of_asset);
        }
        Ok(())
    }

    async fn pose_skin(&mut self, states: &[State]) -> Result<()> {
        for batch in &mut self.list {
            let states = &states[batch.members.clone()];
            if !states.is_empty() {
                batch.evaluator.pose_skin(states).await?;
            }
        }
        Ok(())
    }
}
