//! What the states that a step ends with tell: contacts, energies, and what holds prescribed bones.

use super::members::Members;
use super::minimisation::SkeletonEnd;
use super::newton::Newton;
use crate::Result;
use crate::potential::StepEnd;

/// Whose ends are asked for, and what is said of them; kept from step to step.
pub(super) struct StepEnds {
    wanted: Vec<bool>,
    /// What the tissue says, and of whom that is of the step before.
    ends: Vec<StepEnd>,
    late: Vec<bool>,
    /// What the skeleton says at the step's end and at that of the step before.
    skeletons: Vec<[SkeletonEnd; 2]>,
    /// Whose end the step before has asked for.
    known: Vec<bool>,
}

impl StepEnds {
    /// Room for instances of so many frames each.
    pub fn new(frames: impl Iterator<Item = usize>) -> Self {
        let both = |frames| [SkeletonEnd::new(frames), SkeletonEnd::new(frames)];
        let skeletons: Vec<_> = frames.map(both).collect();
        let count = skeletons.len();
        Self {
            wanted: vec![false; count],
            ends: vec![StepEnd::default(); count],
            late: vec![false; count],
            skeletons,
            known: vec![false; count],
        }
    }

    /// The next report on a member is not of an earlier step.
    pub fn forget(&mut self, member: usize) {
        self.known[member] = false;
    }

    /// Reports on where the active members are that are `wanted`, one after the other.
    pub async fn report<M: Members>(
        &mut self,
        members: &mut M,
        newton: &mut Newton,
        wanted: impl Iterator<Item = bool>,
    ) -> Result<()> {
        for ((to, wanted), active) in self.wanted.iter_mut().zip(wanted).zip(&newton.active) {
            *to = *active && wanted;
        }
        // Until the step is done, there is no earlier one.
        std::mem::swap(&mut self.late, &mut self.known);
        self.known.fill(false);
        if !self.wanted.contains(&true) {
            return Ok(());
        }
        let states = &newton.iterates.states;
        let ends = newton.minimisations.iter().zip(&mut self.skeletons);
        for (i, (minimisation, skeletons)) in ends.enumerate().filter(|(i, _)| self.wanted[*i]) {
            skeletons.swap(0, 1);
            minimisation.skeleton_end(&states[i], &mut skeletons[0]);
        }
        (members.end_step(states, &self.wanted, &mut self.ends, &mut self.late)).await?;
        let minimisations = newton.minimisations.iter_mut().enumerate();
        for (i, minimisation) in minimisations.filter(|(i, _)| self.wanted[*i]) {
            let skeleton = &self.skeletons[i][usize::from(self.late[i])];
            minimisation.end(skeleton, &self.ends[i]);
        }
        Ok(())
    }

    /// The step is done: the next may tell of its end.
    pub fn keep(&mut self) {
        self.known.clone_from(&self.wanted);
    }
}
