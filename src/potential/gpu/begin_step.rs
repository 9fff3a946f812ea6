//! The start of a step on the GPU.

use super::potential::{GpuPotential, Start};
use super::shared::BatchState;
use super::{Batch, upload};
use crate::model::pose_feature;
use crate::potential::StepStart;
use crate::{Error, GpuError, Result};

impl GpuPotential {
    /// x̄ from θⁿ, ŷ, the lagged damping tangent and the contacts at qⁿ, into the starts' slots.
    pub(super) async fn begin(&mut self, starts: &[StepStart<'_>], active: &[bool]) -> Result<()> {
        self.check_length("starts", starts.len())?;
        self.check_length("active", active.len())?;
        for (start, _) in starts.iter().zip(active).filter(|(_, a)| **a) {
            self.check_state(start.previous)?;
            self.check_state(start.current)?;
            if !(start.time_step > 0.0 && start.time_step.is_finite()) {
                return Err(Error::invalid("time_step", "must be positive (s)"));
            }
            if start.colliders.len() > self.options.colliders {
                return Err(GpuError::Limit {
                    what: "colliders of an instance".to_owned(),
                    needed: start.colliders.len() as u64,
                    limit: self.options.colliders as u64,
                    cure: "raise GpuOptions::colliders",
                }
                .into());
            }
            start.validate_contact(&self.body_frames)?;
            // Once there was friction, every start's list is made anew.
            self.has_friction |= start.colliders.iter().any(|c| c.friction > 0.0);
        }
        self.batch.clear();
        self.features.clear();
        for (i, start) in starts.iter().enumerate().filter(|(i, _)| active[*i]) {
            let origin = start.current.frames[0].position;
            let h = start.time_step;
            let header = BatchState {
                gravity: start.tissue_gravity.as_vec3().to_array(),
                mass_rate: (1.0 / (h * h)) as f32,
                damping_rate: (self.avatar.damping_time / h) as f32,
                instance: i as u32,
                colliders: start.colliders.len() as u32,
                smoothing: (start.slip_speed * h) as f32,
                ..BatchState::default()
            };
            let first = i * self.options.colliders;
            for end in [false, true] {
                self.colliders.clear();
                for collider in start.colliders {
                    let slot = self.buffers.grids.slot(&self.queue, collider)?;
                    (self.colliders).push(upload::collider(collider, origin, end, slot));
                }
                let buffer = match end {
                    false => &self.buffers.previous_colliders,
                    true => &self.buffers.colliders,
                };
                buffer.write(&self.queue, first, &self.colliders);
            }

            // The start's own slot: from qⁿ⁻¹ to qⁿ, undamped.
            self.frames.clear();
            self.handles.clear();
            let slot = BatchState {
                damping_rate: 0.0,
                slot: i as u32,
                base: i as u32,
                ..header
            };
            self.push(slot, start.previous, start.current, origin);
            self.upload(i);
            self.push_features(start.current);
            self.starts[i] = Some(Start {
                origin,
                current: start.current.clone(),
                header,
                geometric: start
                    .geometric_contact
                    .then(|| pose_feature(&self.avatar.skeleton.parents, &start.current.frames)),
            });
        }
        (self.buffers.features).write(&self.queue, 0, &self.features);
        let batch = Batch {
            chunk: 0,
            states: self.batch.len() as u32,
        };
        let has_friction = self.has_friction;
        let damped = self.avatar.damping_time > 0.0;
        // Usually a step starts from the pose that was just drawn: then x̄ of the skin is there already.
        let drawn = self.is_posed();
        if drawn {
            self.copy_posed_rest();
        }
        self.submit(
            |stages, pass| {
                stages.pose_blend.dispatch_cubature(pass, batch);
                if !drawn {
                    stages.pose_blend.dispatch_skin(pass, batch);
                }
                stages.displacement.dispatch(pass, batch);
                if damped {
                    stages.elasticity.dispatch(pass, batch);
                }
                stages.contact.dispatch(pass, batch);
                if has_friction {
                    stages.contact.dispatch_lagged(pass, batch);
                    stages.friction.dispatch_lag(pass, batch);
                }
            },
            |_| {},
        );
        Ok(())
    }

    /// Whether every state of the batch has the pose features that its instance was last drawn with.
    fn is_posed(&self) -> bool {
        if self.features.is_empty() || self.batch.is_empty() {
            return false;
        }
        let features = self.features.len() / self.batch.len();
        (self.batch.iter())
            .zip(self.features.chunks_exact(features))
            .all(|(state, features)| self.posed_features[state.instance as usize] == features)
    }

    /// Takes x̄ of the drawn skin over for the instances of the batch.
    fn copy_posed_rest(&self) {
        let bytes = 16 * self.avatar.skin.len() as u64;
        let mut encoder = self.device.create_command_encoder(&Default::default());
        for state in &self.batch {
            let at = u64::from(state.instance) * bytes;
            let (from, to) = (&self.buffers.posed_skin_unposed, &self.buffers.skin.unposed);
            encoder.copy_buffer_to_buffer(from.raw(), at, to.raw(), at, bytes);
        }
        self.queue.submit([encoder.finish()]);
    }
}
