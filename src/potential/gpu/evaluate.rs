//! Energy, gradient and Hessian on the GPU: one submission (one a chunk, where the scratch memory does not hold all
//! states) and one readback.

use super::geometric::geometric_terms;
use super::potential::{GpuPotential, Start};
use super::shared::{BatchState, Summary};
use super::stage::Stage;
use crate::model::State;
use crate::potential::{Energies, Evaluation};
use crate::{Error, Result};
use glam::Vec3;

/// Every active state, from its instance's start.
pub(super) async fn evaluate(
    potential: &mut GpuPotential,
    states: &[State],
    active: &[bool],
    out: &mut [Evaluation],
) -> Result<()> {
    let begun = |i: usize| potential.starts[i].is_some();
    (potential.checks).states(states, active, out.len(), begun)?;
    let instances = potential.starts.len();
    potential.clear_uploads();
    for (i, state) in states.iter().enumerate().filter(|(i, _)| active[*i]) {
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
    potential.upload_prescribed();
    let summary_bytes = (count * size_of::<Summary>()) as u64;
    let stride = potential.buffers.sizes.result;
    let contacts_at = summary_bytes + (4 * count * stride) as u64;
    let contact_bytes = potential.buffers.sizes.contact_bytes();
    let wanted = |batch_state: &BatchState| {
        let start = potential.starts[batch_state.instance as usize].as_ref();
        start.is_some_and(|start| start.geometric.is_some())
    };
    let geometric = potential.batch.iter().any(wanted);
    let bytes = contacts_at
        + if geometric {
            (count * contact_bytes) as u64
        } else {
            0
        };
    let mut done = 0;
    for batch in potential.chunks(count) {
        let first = done;
        done += batch.states as usize;
        potential.submit(
            |stages, pass| {
                stages.displacement.dispatch(pass, batch);
                stages.elasticity.dispatch(pass, batch);
                stages.contact.dispatch(pass, batch);
                if potential.has_friction {
                    stages.friction.dispatch(pass, batch);
                }
                stages.compact.dispatch(pass, batch);
                stages.gradient.dispatch(pass, batch);
                stages.point_hessian.dispatch(pass, batch);
                stages.hessian.dispatch(pass, batch);
                stages.energy.dispatch(pass, batch);
            },
            |encoder| {
                if geometric {
                    // The next chunk writes over them.
                    let contacts = potential.buffers.common.contacts.raw();
                    let range = 0..((done - first) * contact_bytes) as u64;
                    let at = contacts_at + (first * contact_bytes) as u64;
                    (potential.readback).record(encoder, contacts, range, at);
                }
                if done == count {
                    let summaries = potential.buffers.common.summaries.raw();
                    (potential.readback).record(encoder, summaries, 0..summary_bytes, 0);
                    let result = potential.buffers.common.result.raw();
                    let range = 0..contacts_at - summary_bytes;
                    (potential.readback).record(encoder, result, range, summary_bytes);
                }
            },
        );
    }
    let dofs = potential.avatar.space().dofs();
    let batch = &potential.batch;
    let unpack =
        |bytes: &[u8]| {
            let (results, contacts) = bytes.split_at(contacts_at as usize);
            let (summaries, results) = results.split_at(summary_bytes as usize);
            let mut found = Vec::with_capacity(count);
            let summaries = summaries.chunks_exact(size_of::<Summary>());
            found.extend(summaries.map(bytemuck::pod_read_unaligned::<Summary>));
            if !results.chunks_exact(4).all(|b| float(b).is_finite()) {
                return Err(Error::NotFinite {
                    quantity: "gradient or Hessian of the tissue",
                });
            }
            for (b, summary) in found.iter().enumerate() {
                let instance = batch[b].instance as usize;
                let evaluation = &mut out[instance];
                evaluation.energies = energies(summary)?;
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
                evaluation.hessian.extend(blocks.map(|block| {
                    std::array::from_fn(|k| f64::from(float(&block[4 * k..4 * k + 4])))
                }));
                let contacts = contacts.get(b * contact_bytes..).unwrap_or_default();
                let (start, state) = (potential.start(instance)?, &states[instance]);
                geometric_terms(potential, start, state, contacts, &mut evaluation.geometric);
            }
            Ok(())
        };
    potential
        .readback
        .read(&potential.device, bytes, unpack)
        .await?
}

/// The number in four bytes.
pub(super) fn float(bytes: &[u8]) -> f32 {
    bytemuck::pod_read_unaligned(bytes)
}

/// The energies, if they are finite.
pub(super) fn energies(summary: &Summary) -> Result<Energies> {
    let e = &summary.energy;
    let energies = Energies {
        inertia: e.inertia.into(),
        gravity: e.gravity.into(),
        elastic: e.elastic.into(),
        damping: e.damping.into(),
        contact: e.contact.into(),
        friction: e.friction.into(),
    };
    if energies.total().is_finite() && e.force.iter().all(|f| f.is_finite()) {
        return Ok(energies);
    }
    Err(Error::NotFinite {
        quantity: "energy of the tissue",
    })
}
