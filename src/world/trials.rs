//! Energy differences of members of any assets: the trials of a line search.

use super::evaluators::Evaluators;
use crate::Result;
use crate::math::recycled;
use crate::potential::{Difference, Potential, Trial};
use std::ops::Range;

/// An asset's part of an energy difference, in memory that is kept.
#[derive(Default)]
pub(super) struct OwnTrials {
    trials: Vec<Trial<'static>>,
    /// Which of all trials they are.
    places: Vec<usize>,
    differences: Vec<Difference>,
    /// Those of them that the device is asked about.
    #[cfg(feature = "gpu")]
    asked: Range<usize>,
}

impl OwnTrials {
    /// Finds those of `members` among all `trials`.
    fn find(&mut self, members: &Range<usize>, trials: &[Trial<'_>]) {
        self.places.clear();
        let own = |k: &usize| members.contains(&trials[*k].instance);
        self.places.extend((0..trials.len()).filter(own));
        self.differences.clear();
        self.differences
            .resize(self.places.len(), Difference::default());
    }

    /// Its own from the `first` on, in memory to be given back.
    fn list<'a>(
        &mut self,
        members: &Range<usize>,
        trials: &[Trial<'a>],
        first: usize,
    ) -> Vec<Trial<'a>> {
        let mut own: Vec<Trial<'a>> = recycled(std::mem::take(&mut self.trials));
        own.extend(self.places[first..].iter().map(|&k| Trial {
            instance: trials[k].instance - members.start,
            ..trials[k]
        }));
        own
    }
}

impl Evaluators {
    /// E(state) − E(base) of each trial; those on the GPU in as many submissions as there is room for.
    pub(super) async fn compare(
        &mut self,
        trials: &[Trial<'_>],
        out: &mut [Difference],
    ) -> Result<()> {
        for asset in &mut self.list {
            asset.trials.find(&asset.members, trials);
        }
        #[cfg(feature = "gpu")]
        let mut more = self.record_differences(trials, true)?;
        for asset in &mut self.list {
            let own = &mut asset.trials;
            if let Some(potential) = asset.evaluator.on_cpu()
                && !own.places.is_empty()
            {
                let list = own.list(&asset.members, trials, 0);
                Potential::energy_differences(potential, &list, &mut own.differences).await?;
                own.trials = recycled(list);
            }
        }
        #[cfg(feature = "gpu")]
        while more {
            self.read_differences().await?;
            more = self.record_differences(trials, false)?;
        }
        for own in self.list.iter().map(|asset| &asset.trials) {
            for (&k, difference) in own.places.iter().zip(&own.differences) {
                out[k] = *difference;
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
        for asset in &mut self.list {
            let own = &mut asset.trials;
            let done = if first { 0 } else { own.asked.end };
            own.asked = done..done;
            if let Some(potential) = asset.evaluator.on_gpu()
                && done < own.places.len()
            {
                let list = own.list(&asset.members, trials, done);
                let recorder = potential.recorder();
                let count = recorder.record_energy_differences(&list, submission)?;
                own.asked = done..done + count;
                own.trials = recycled(list);
                any |= count > 0;
            }
        }
        submission.flush();
        Ok(any)
    }

    /// The answers to them.
    async fn read_differences(&mut self) -> Result<()> {
        let Some(shared) = &mut self.shared else {
            return Ok(());
        };
        let bytes = shared.read(&mut self.list).await?;
        for asset in &mut self.list {
            let own = &mut asset.trials;
            if let Some(potential) = asset.evaluator.on_gpu()
                && !own.asked.is_empty()
            {
                let out = &mut own.differences[own.asked.clone()];
                let recorder = potential.recorder();
                recorder.finish_energy_differences(&bytes, out)?;
            }
        }
        Ok(())
    }
}
