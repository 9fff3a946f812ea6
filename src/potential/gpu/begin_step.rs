//! The start of a step on the GPU.

use super::dispatch::Batch;
use super::pack;
use super::potential::{GpuPotential, Start};
use super::shared::BatchState;
use super::stage::Stage;
use crate::model::pose_feature;
use crate::potential::StepStart;
use crate::{GpuError, Result};

/// x̄ from θⁿ, ŷ, the lagged damping tangent and the contacts at qⁿ, into the starts' slots.
pub(super) async fn begin_step(
    potential: &mut GpuPotential,
    starts: &[StepStart<'_>],
    active: &[bool],
) -> Result<()> {
    potential.checks.starts(starts, active)?;
    for (start, _) in starts.iter().zip(active).filter(|(_, a)| **a) {
        if start.colliders.len() > potential.options.colliders {
            return Err(GpuError::Limit {
                what: "colliders of an instance".to_owned(),
                needed: start.colliders.len() as u64,
                limit: potential.options.colliders as u64,
                cure: "raise GpuOptions::colliders",
            }
            .into());
        }
        // Once there was friction, every start's list is made anew.
        potential.has_friction |= start.colliders.iter().any(|c| c.friction > 0.0);
        potential.has_prescribed |= start.prescribed.contains(&true);
        // Likewise once more pairs might touch than there is room for.
        let pairs = start.colliders.len() * potential.avatar.skin.len();
        potential.selects |= pairs > potential.options.contacts;
    }
    potential.batch.clear();
    potential.features.clear();
    for (i, start) in starts.iter().enumerate().filter(|(i, _)| active[*i]) {
        let origin = start.current.frames[0].position;
        let (h, factors) = (start.time_step, start.factors);
        let batch_state = BatchState {
            gravity: pack::round(factors.gravity * start.tissue_gravity),
            mass_rate: (1.0 / (h * h)) as f32,
            damping_rate: (factors.damping * potential.avatar.damping_time / h) as f32,
            instance: i as u32,
            colliders: start.colliders.len() as u32,
            smoothing: (start.slip_speed * h) as f32,
            stiffness: factors.stiffness as f32,
            ..BatchState::default()
        };
        let first = i * potential.options.colliders;
        for end in [false, true] {
            potential.colliders.clear();
            for collider in start.colliders {
                let grid = potential.buffers.grids.index(&potential.queue, collider)?;
                (potential.colliders).push(pack::collider(
                    collider,
                    factors.friction,
                    origin,
                    end,
                    grid,
                ));
            }
            let buffer = match end {
                false => &potential.buffers.common.previous_colliders,
                true => &potential.buffers.common.colliders,
            };
            buffer.write(&potential.queue, first, &potential.colliders);
        }

        // The start's own slot: from qⁿ⁻¹ to qⁿ, undamped.
        potential.frames.clear();
        potential.handles.clear();
        let slot = BatchState {
            damping_rate: 0.0,
            slot: i as u32,
            base: i as u32,
            ..batch_state
        };
        potential.push_state(slot, start.previous, start.current, origin);
        potential.upload(i);
        potential.push_features(start.current);
        potential.starts[i] = Some(Start {
            origin,
            current: start.current.clone(),
            batch_state,
            prescribed: start.prescribed.to_vec(),
            geometric: start
                .geometric_contact
                .then(|| pose_feature(&potential.avatar.skeleton.parents, &start.current.frames)),
        });
    }
    (potential.buffers.common.pose_features).write(&potential.queue, 0, &potential.features);
    let batch = Batch::whole(potential.batch.len());
    let (has_friction, selects) = (potential.has_friction, potential.selects);
    let damped = potential.avatar.damping_time > 0.0;
    // Usually a step starts from the pose that the skin was just posed in: then x̄ of the skin is there already.
    let posed = is_posed(potential);
    if posed {
        copy_posed_rest(potential);
    }
    potential.submit(
        |stages, pass| {
            stages.pose_blend.dispatch(pass, batch);
            if !posed {
                stages.pose_blend.dispatch_skin(pass, batch);
            }
            stages.displacement.dispatch(pass, batch);
            if damped {
                stages.elasticity.dispatch(pass, batch);
            }
            stages.contact.dispatch(pass, batch);
            if selects {
                stages.select.dispatch(pass, batch);
            }
            if has_friction {
                stages.contact.dispatch_lagged(pass, batch);
                if selects {
                    stages.select.dispatch_lagged(pass, batch);
                }
                stages.friction.dispatch_lag(pass, batch);
            }
        },
        |_| {},
    );
    Ok(())
}

/// Whether every state of the batch has the pose features that its instance was last posed with.
fn is_posed(potential: &GpuPotential) -> bool {
    if potential.features.is_empty() || potential.batch.is_empty() {
        return false;
    }
    let features = potential.features.len() / potential.batch.len();
    (potential.batch.iter())
        .zip(potential.features.chunks_exact(features))
        .all(|(state, features)| potential.posed_features[state.instance as usize] == features)
}

/// Takes x̄ of the posed skin over for the instances of the batch.
fn copy_posed_rest(potential: &GpuPotential) {
    let bytes = 16 * potential.avatar.skin.len() as u64;
    let mut encoder = potential.device.create_command_encoder(&Default::default());
    for state in &potential.batch {
        let at = u64::from(state.instance) * bytes;
        let (from, to) = (
            &potential.buffers.common.posed_skin_unposed,
            &potential.buffers.skin.unposed,
        );
        encoder.copy_buffer_to_buffer(from.raw(), at, to.raw(), at, bytes);
    }
    potential.queue.submit([encoder.finish()]);
}
