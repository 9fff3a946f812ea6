//! What contact does to each skin vertex, on request: the stages that list the contacts run at one state, and their rows are
//! read back. So it is what the step itself computed with, and not a second opinion.

use super::geometric::contact_rows;
use super::recorder::Recorder;
use super::stage::Stage;
use crate::gpu::Submission;
use crate::model::State;
use crate::potential::cpu::contact_forces::sum_by_vertex;
use crate::{Error, Result};
use glam::DVec3;

impl Recorder {
    /// The contacts of `instance` at `state`, from its start.
    ///
    /// # Errors
    /// A state that is not one of this asset's or does not fit f32; an instance that has begun no step.
    pub fn record_contacts(
        &mut self,
        instance: usize,
        state: &State,
        submission: &mut Submission,
    ) -> Result<()> {
        self.push_one_state(instance, state)?;
        let bytes = self.buffers.sizes.contact_bytes() as u64;
        let room = submission.reserve(bytes)?;
        self.results = room.start as usize..room.end as usize;
        self.claim_states(submission);
        self.upload_states(self.starts.len());
        self.upload_batch(0);
        for batch in self.chunks(1) {
            self.dispatch(submission, |stages, pass| {
                stages.contact.dispatch(pass, batch);
                if self.has_friction {
                    stages.friction.dispatch(pass, batch);
                }
                stages.compact.dispatch(pass, batch);
            });
        }
        submission.copy(self.buffers.common.contacts.raw(), 0..bytes, room.start);
        Ok(())
    }

    /// Forces (N) and pressures (Pa) on the skin's vertices of what [`Recorder::record_contacts`] brought back in `bytes`.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::Invalid`] where `bytes` are others.
    pub fn finish_contacts(
        &self,
        bytes: &[u8],
        forces: &mut Vec<DVec3>,
        pressures: &mut Vec<f64>,
    ) -> Result<()> {
        let areas = &self.avatar.skin.measure;
        let (found, rows) = contact_rows(self.own(bytes)?, areas.len());
        let pushes = found.min(self.buffers.sizes.contacts);
        sum_by_vertex(rows, pushes, areas, forces, pressures);
        if forces.iter().all(|force| force.is_finite()) {
            return Ok(());
        }
        let quantity = "contact force";
        Err(Error::NotFinite { quantity })
    }
}
