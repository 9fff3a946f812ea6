//! What the state at a step's end tells, on the GPU: the stages of an evaluation without those that only the handles'
//! derivatives need. One submission (one a chunk) and one readback of some hundred bytes a frame.

use super::evaluate::{energies, float};
use super::potential::{GpuPotential, Start};
use super::shared::{BatchState, Summary};
use super::stage::Stage;
use crate::model::State;
use crate::potential::StepEnd;
use crate::{Error, Result};
use glam::Vec3;

/// Every wanted state, from its instance's start.
pub(super) async fn end_step(
    potential: &mut GpuPotential,
    states: &[State],
    wanted: &[bool],
    out: &mut [StepEnd],
) -> Result<()> {
    let begun = |i: usize| potential.starts[i].is_some();
    (potential.checks).states(states, wanted, out.len(), begun)?;
    let instances = potential.starts.len();
    potential.clear_uploads();
    for (i, state) in states.iter().enumerate().filter(|(i, _)| wanted[*i]) {
        let Start {
            origin,
            current,
            batch_state,
            ..
        } = potential.start(i)?.clone();
        let batch_state = BatchState {
            slot: (instances + potential.batch.len()) as u32,
            base: i as u32,
            ..batch_state
        };
        potential.push_state(batch_state, &current, state, origin);
    }
    let count = potential.batch.len();
    if count == 0 {
        return Ok(());
    }
    potential.upload(instances);
    let summary_bytes = (count * size_of::<Summary>()) as u64;
    let stride = 4 * potential.buffers.sizes.result as u64;
    let gradient_bytes = 4 * 6 * potential.buffers.sizes.bones as u64;
    let mut done = 0;
    for batch in potential.chunks(count) {
        done += batch.states as usize;
        potential.submit(
            |stages, pass| {
                stages.displacement.dispatch(pass, batch);
                stages.contact.dispatch(pass, batch);
                if potential.has_friction {
                    stages.friction.dispatch(pass, batch);
                }
                stages.compact.dispatch(pass, batch);
                stages.gradient.dispatch_frames(pass, batch);
                stages.energy.dispatch(pass, batch);
            },
            |encoder| {
                if done == count {
                    let (readback, common) = (&potential.readback, &potential.buffers.common);
                    readback.record(encoder, common.summaries.raw(), 0..summary_bytes, 0);
                    for b in 0..count as u64 {
                        let range = b * stride..b * stride + gradient_bytes;
                        let at = summary_bytes + b * gradient_bytes;
                        readback.record(encoder, common.result.raw(), range, at);
                    }
                }
            },
        );
    }
    let batch = &potential.batch;
    let unpack = |bytes: &[u8]| {
        let (summaries, gradients) = bytes.split_at(summary_bytes as usize);
        let summaries = summaries.chunks_exact(size_of::<Summary>());
        let gradients = gradients.chunks_exact(gradient_bytes as usize);
        for ((state, summary), gradient) in batch.iter().zip(summaries).zip(gradients) {
            let summary: Summary = bytemuck::pod_read_unaligned(summary);
            let end = &mut out[state.instance as usize];
            end.energies = energies(&summary)?;
            end.contact_force = Vec3::from_array(summary.energy.force).as_dvec3();
            end.contacts = summary.contacts as usize;
            end.contacts_left_out = summary.energy.left_out as usize;
            end.frame_gradient.clear();
            let numbers = gradient.chunks_exact(4).map(|b| f64::from(float(b)));
            end.frame_gradient.extend(numbers);
            if !end.frame_gradient.iter().all(|g| g.is_finite()) {
                return Err(Error::NotFinite {
                    quantity: "gradient of the tissue by frames",
                });
            }
        }
        Ok(())
    };
    potential
        .readback
        .read(
            &potential.device,
            summary_bytes + count as u64 * gradient_bytes,
            unpack,
        )
        .await?
}
