//! Energy, gradient and Hessian on the GPU, in chunks where the scratch memory does not hold all states.

use super::geometric::geometric_terms;
use super::recorder::Recorder;
use super::shared::Summary;
use super::stage::Stage;
use crate::gpu::Submission;
use crate::model::State;
use crate::potential::{Energies, Evaluation};
use crate::{Error, Result};
use glam::Vec3;

/// Where the parts of what a batch reads back begin: summaries, then gradients and Hessians, then, where they are wanted,
/// contacts.
struct Parts {
    results: usize,
    contacts: usize,
    end: usize,
}

impl Recorder {
    /// Every active state, from its instance's start.
    ///
    /// # Errors
    /// As [`Potential::evaluate`](crate::potential::Potential::evaluate), and [`crate::GpuError::Limit`] where the
    /// submission has no room to read it back; nothing is recorded then.
    pub fn record_evaluate(
        &mut self,
        states: &[State],
        active: &[bool],
        submission: &mut Submission,
    ) -> Result<()> {
        self.push_states(states, active)?;
        let count = self.batch.len();
        if count == 0 {
            return Ok(());
        }
        let parts = self.parts();
        let room = submission.reserve(parts.end as u64)?;
        self.results = room.start as usize..room.end as usize;
        self.claim_states(submission);
        self.upload_states(self.starts.len());
        self.upload_batch(0);
        self.upload_prescribed();
        let contact_bytes = self.buffers.sizes.contact_bytes();
        let mut done = 0;
        for batch in self.chunks(count) {
            self.dispatch(submission, |stages, pass| {
                stages.displacement.dispatch(pass, batch);
                stages.elasticity.dispatch(pass, batch);
                stages.contact.dispatch(pass, batch);
                if self.has_friction {
                    stages.friction.dispatch(pass, batch);
                }
                stages.compact.dispatch(pass, batch);
                stages.gradient.dispatch(pass, batch);
                stages.point_hessian.dispatch(pass, batch);
                stages.hessian.dispatch(pass, batch);
                stages.energy.dispatch(pass, batch);
            });
            if parts.end > parts.contacts {
                // The next chunk writes over them.
                let contacts = self.buffers.common.contacts.raw();
                let bytes = (batch.states as usize * contact_bytes) as u64;
                let at = room.start + (parts.contacts + done * contact_bytes) as u64;
                submission.copy(contacts, 0..bytes, at);
            }
            done += batch.states as usize;
        }
        let summaries = self.buffers.common.summaries.raw();
        submission.copy(summaries, 0..parts.results as u64, room.start);
        let result = self.buffers.common.result.raw();
        let bytes = (parts.contacts - parts.results) as u64;
        submission.copy(result, 0..bytes, room.start + parts.results as u64);
        Ok(())
    }

    /// Unpacks what [`Recorder::record_evaluate`] of `states` brought back in `bytes`.
    ///
    /// # Errors
    /// [`Error::NotFinite`]; [`Error::Invalid`] where `bytes`, `states` or `out` are others.
    pub fn finish_evaluate(
        &mut self,
        bytes: &[u8],
        states: &[State],
        out: &mut [Evaluation],
    ) -> Result<()> {
        self.checks.count("states", states.len())?;
        self.checks.count("out", out.len())?;
        let bytes = self.own(bytes)?;
        if bytes.is_empty() {
            return Ok(());
        }
        let parts = self.parts();
        let (results, contacts) = bytes.split_at(parts.contacts);
        let (summaries, results) = results.split_at(parts.results);
        if !results.chunks_exact(4).all(|b| is_sound(float(b))) {
            return Err(Error::NotFinite {
                quantity: "gradient or Hessian of the tissue",
            });
        }
        let dofs = self.avatar.space().dofs();
        let stride = self.buffers.sizes.result;
        let contact_bytes = self.buffers.sizes.contact_bytes();
        let summaries = summaries.chunks_exact(size_of::<Summary>());
        for (b, summary) in summaries.enumerate() {
            let summary: Summary = bytemuck::pod_read_unaligned(summary);
            let instance = self.batch[b].instance as usize;
            let evaluation = &mut out[instance];
            evaluation.energies = energies(&summary)?;
            evaluation.contact_force = Vec3::from_array(summary.energy.force).as_dvec3();
            evaluation.contacts = summary.contacts as usize;
            evaluation.contacts_left_out = summary.energy.left_out as usize;
            let (gradient, hessian) =
                results[4 * b * stride..4 * (b + 1) * stride].split_at(4 * dofs);
            evaluation.gradient.clear();
            let numbers = gradient.chunks_exact(4).map(|b| f64::from(float(b)));
            evaluation.gradient.extend(numbers);
            evaluation.hessian.clear();
            let blocks = hessian.chunks_exact(36);
            evaluation.hessian.extend(
                blocks.map(|block| {
                    std::array::from_fn(|k| f64::from(float(&block[4 * k..4 * k + 4])))
                }),
            );
            let contacts = contacts.get(b * contact_bytes..).unwrap_or_default();
            let (start, state) = (self.start(instance)?, &states[instance]);
            geometric_terms(self, start, state, contacts, &mut evaluation.geometric);
        }
        Ok(())
    }

    fn parts(&self) -> Parts {
        let count = self.batch.len();
        let geometric = self.batch.iter().any(|state| {
            let start = self.starts[state.instance as usize].as_ref();
            start.is_some_and(|start| start.geometric.is_some())
        });
        let results = count * size_of::<Summary>();
        let contacts = results + 4 * count * self.buffers.sizes.result;
        let end = contacts + usize::from(geometric) * count * self.buffers.sizes.contact_bytes();
        Parts {
            results,
            contacts,
            end,
        }
    }
}

/// The number in four bytes.
pub(super) fn float(bytes: &[u8]) -> f32 {
    bytemuck::pod_read_unaligned(bytes)
}

/// Whether `x` is what a device computes without overflow. The kernels' language promises no infinity and no NaN where
/// numbers overflow; no tissue has energies (J), forces or stiffnesses so large.
pub(super) fn is_sound(x: f32) -> bool {
    x.abs() < 1e30
}

/// The energies, if they are sound.
pub(super) fn energies(summary: &Summary) -> Result<Energies> {
    let e = &summary.energy;
    let terms = [
        e.inertia, e.gravity, e.elastic, e.damping, e.contact, e.friction,
    ];
    if !(terms.iter().chain(&e.force)).all(|&x| is_sound(x)) {
        return Err(Error::NotFinite {
            quantity: "energy of the tissue",
        });
    }
    Ok(Energies {
        inertia: e.inertia.into(),
        gravity: e.gravity.into(),
        elastic: e.elastic.into(),
        damping: e.damping.into(),
        contact: e.contact.into(),
        friction: e.friction.into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn huge_energies_count_as_not_finite() {
        let mut summary = Summary::default();
        summary.energy.elastic = 1e29;
        assert!(energies(&summary).is_ok());
        for bad in [1e30, -1e30, f32::INFINITY, f32::NAN] {
            summary.energy.elastic = bad;
            assert!(matches!(energies(&summary), Err(Error::NotFinite { .. })));
        }
        summary = Summary::default();
        summary.energy.force[1] = f32::NAN;
        assert!(energies(&summary).is_err());
    }
}
