//! The ends of steps on the GPU. What they tell comes back with the next step's first results, so that nobody waits for it.

use super::evaluators::{AssetEvaluator, Evaluators};
use crate::model::State;
use crate::potential::StepEnd;
use crate::{Error, Result};

/// What an asset's instances on the GPU ended their steps with.
#[derive(Default)]
pub(super) struct LateEnds {
    /// Whose end has been recorded and not been asked back, and whose is on its way.
    recorded: Vec<bool>,
    coming: Vec<bool>,
    /// What has come last, and whose it is.
    ends: Vec<StepEnd>,
    known: Vec<bool>,
}

impl LateEnds {
    /// Room for `count` instances, of none of which anything is known.
    pub fn set_count(&mut self, count: usize) {
        for flags in [&mut self.recorded, &mut self.coming, &mut self.known] {
            flags.clear();
            flags.resize(count, false);
        }
        self.ends.resize_with(count, StepEnd::default);
    }

    /// Whether an end is known of all that are `wanted`.
    fn are_known(&self, wanted: &[bool]) -> bool {
        wanted
            .iter()
            .zip(&self.known)
            .all(|(wanted, known)| !wanted || *known)
    }

    /// Those of the instances that are `wanted`.
    fn tell(&self, wanted: &[bool], out: &mut [StepEnd]) {
        let wanted = out
            .iter_mut()
            .zip(&self.ends)
            .zip(wanted)
            .filter(|(_, wanted)| **wanted);
        wanted.for_each(|((out, end), _)| out.clone_from(end));
    }
}

impl AssetEvaluator {
    /// Before anything is read back: what is known is of an earlier step, if another end has been recorded.
    pub fn await_end(&mut self) {
        let LateEnds {
            recorded,
            coming,
            known,
            ..
        } = &mut self.ends;
        if recorded.contains(&true) {
            known.fill(false);
        }
        std::mem::swap(recorded, coming);
        recorded.fill(false);
    }

    /// Takes what has come back in `bytes` of an end that was recorded. One that is not finite stays unknown.
    pub fn take_end(&mut self, bytes: &[u8]) {
        let ends = &mut self.ends;
        if let Some(potential) = self.evaluator.on_gpu()
            && ends.coming.contains(&true)
            && potential
                .recorder()
                .finish_end_step(bytes, &mut ends.ends)
                .is_ok()
        {
            ends.known.copy_from_slice(&ends.coming);
        }
    }
}

impl Evaluators {
    /// Records the ends of those that are `wanted`. Whether their answers must be waited for: not where those of the step
    /// before are known of all, and may be told instead.
    pub(super) fn record_end_step(
        &mut self,
        states: &[State],
        wanted: &[bool],
        late: &[bool],
    ) -> Result<bool> {
        let Some(shared) = &mut self.shared else {
            return Ok(false);
        };
        let submission = shared.begin();
        let mut waits = false;
        for asset in &mut self.list {
            let range = asset.members.clone();
            let (wanted, late) = (&wanted[range.clone()], &late[range.clone()]);
            if let Some(potential) = asset.evaluator.on_gpu() {
                let recorder = potential.recorder();
                recorder.record_end_step(&states[range], wanted, submission)?;
                let may_be_late = wanted
                    .iter()
                    .zip(late)
                    .all(|(wanted, late)| !wanted || *late);
                waits |= !(may_be_late && asset.ends.are_known(wanted));
            }
        }
        match waits {
            true => submission.flush(),
            false => submission.keep_reads(),
        }
        for asset in &mut self.list {
            let wanted = &wanted[asset.members.clone()];
            asset.ends.recorded.copy_from_slice(wanted);
        }
        Ok(waits)
    }

    /// Tells the ends of those that are `wanted`: of this step where `waits`, else of the one before.
    pub(super) async fn tell_ends(
        &mut self,
        wanted: &[bool],
        waits: bool,
        out: &mut [StepEnd],
        late: &mut [bool],
    ) -> Result<()> {
        let Some(shared) = self.shared.as_mut() else {
            return Ok(());
        };
        if waits {
            shared.read(&mut self.list).await?;
        }
        for asset in &mut self.list {
            let range = asset.members.clone();
            if asset.evaluator.on_gpu().is_none() {
                continue;
            }
            let wanted = &wanted[range.clone()];
            if !asset.ends.are_known(wanted) {
                let quantity = "end of the step";
                return Err(Error::NotFinite { quantity });
            }
            asset.ends.tell(wanted, &mut out[range.clone()]);
            if waits {
                late[range].fill(false);
            }
        }
        Ok(())
    }
}
