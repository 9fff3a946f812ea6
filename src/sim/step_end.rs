//! What the states that a step ends with tell: contacts, energies, and what holds prescribed bones.

use super::newton::Newton;
use crate::Result;
use crate::potential::{Potential, StepEnd};

/// Whose ends are asked for, and what is said of them; kept from step to step.
pub(super) struct StepEnds {
    wanted: Vec<bool>,
    ends: Vec<StepEnd>,
}

impl StepEnds {
    /// Room for `count` instances.
    pub fn new(count: usize) -> Self {
        Self {
            wanted: vec![false; count],
            ends: vec![StepEnd::default(); count],
        }
    }

    /// Reports on where the active instances are that are `wanted`, one after the other.
    pub async fn report<P: Potential>(
        &mut self,
        potential: &mut P,
        newton: &mut Newton,
        wanted: impl Iterator<Item = bool>,
    ) -> Result<()> {
        for ((to, wanted), active) in self.wanted.iter_mut().zip(wanted).zip(&newton.active) {
            *to = *active && wanted;
        }
        if !self.wanted.contains(&true) {
            return Ok(());
        }
        let states = &newton.iterates.states;
        (potential.end_step(states, &self.wanted, &mut self.ends)).await?;
        let reports = newton.minimisations.iter_mut().zip(states).zip(&self.ends);
        for ((minimisation, state), end) in reports
            .zip(&self.wanted)
            .filter_map(|(r, w)| w.then_some(r))
        {
            minimisation.end(&state.frames, end);
        }
        Ok(())
    }
}
