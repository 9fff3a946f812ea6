//! The start of a step on the GPU.

use super::pack;
use super::recorder::{Recorder, SkinRest, Start};
use super::shared::BatchState;
use super::stage::Stage;
use crate::gpu::Submission;
use crate::model::pose_feature;
use crate::potential::StepStart;
use crate::{Error, GpuError, Result};

impl Recorder {
    /// x̄ from θⁿ, ŷ, the lagged damping tangent and the contacts at qⁿ, into the starts' slots.
    ///
    /// # Errors
    /// As [`Potential::begin_step`](crate::potential::Potential::begin_step); nothing is recorded then.
    pub fn record_begin_step(
        &mut self,
        starts: &[StepStart<'_>],
        active: &[bool],
        submission: &mut Submission,
    ) -> Result<()> {
        self.checks.starts(starts, active)?;
        let started = || (starts.iter().enumerate()).filter(|(i, _)| active[*i]);
        for (_, start) in started() {
            self.check_colliders(start)?;
        }
        self.clear_uploads();
        for (i, start) in started() {
            let origin = start.current.frames[0].position;
            // The start's own slot, undamped.
            let slot = BatchState {
                damping_rate: 0.0,
                slot: i as u32,
                base: i as u32,
                ..self.batch_state(i, start)
            };
            if !self.push_start(slot, start, origin) {
                return Err(Error::NotFinite {
                    quantity: "state at the step's start in f32",
                });
            }
            self.push_features(start.current);
        }
        if self.batch.is_empty() {
            return Ok(());
        }
        let offsets = started().map(|(i, start)| (i, start.pose_offsets));
        self.upload_offsets(offsets, submission);
        self.claim_starts(submission);
        self.upload_batch(self.buffers.sizes.states);
        self.upload_starts();
        for (i, start) in started() {
            self.upload_colliders(i, start)?;
            // Once there was friction, every start's list is made anew.
            self.has_friction |= start.colliders.iter().any(|c| c.friction > 0.0);
            self.has_prescribed |= start.prescribed.contains(&true);
            // Likewise once more pairs might touch than there is room for.
            let pairs = start.colliders.len() * self.avatar.skin.len();
            self.selects |= pairs > self.options.contacts;
            self.starts[i] = Some(Start {
                origin: start.current.frames[0].position,
                current: start.current.clone(),
                batch_state: self.batch_state(i, start),
                prescribed: start.prescribed.to_vec(),
                geometric: start.geometric_contact.then(|| SkinRest {
                    feature: pose_feature(&self.avatar.skeleton.parents, &start.current.frames),
                    offsets: start.pose_offsets.to_vec(),
                }),
            });
        }
        self.dispatch_starts(submission);
        Ok(())
    }

    fn dispatch_starts(&self, submission: &mut Submission) {
        let batch = self.buffers.sizes.starts(self.batch.len());
        // Usually a step starts from the pose that the skin was just posed in: then x̄ of the skin is there already.
        let posed = self.is_posed();
        if posed {
            self.copy_posed_rest(submission);
        }
        self.dispatch(submission, |stages, pass| {
            stages.pose_blend.dispatch(pass, batch);
            if !posed {
                stages.pose_blend.dispatch_skin(pass, batch);
            }
            stages.displacement.dispatch(pass, batch);
            stages.inertial_target.dispatch(pass, batch);
            if self.damped {
                stages.elasticity.dispatch(pass, batch);
            }
            stages.contact.dispatch(pass, batch);
            if self.selects {
                stages.select.dispatch(pass, batch);
            }
            if self.has_friction {
                stages.contact.dispatch_lagged(pass, batch);
                if self.selects {
                    stages.select.dispatch_lagged(pass, batch);
                }
                stages.friction.dispatch_lag(pass, batch);
            }
        });
    }

    /// A state of instance `i`, without its slots.
    fn batch_state(&self, i: usize, start: &StepStart<'_>) -> BatchState {
        let (step, factors) = (start.inertia.step, start.factors);
        BatchState {
            gravity: pack::round(factors.gravity * start.tissue_gravity),
            mass_rate: (1.0 / (step * step)) as f32,
            damping_rate: match self.damped {
                true => (factors.damping / step) as f32,
                false => 0.0,
            },
            instance: i as u32,
            colliders: start.colliders.len() as u32,
            smoothing: (start.slip_speed * start.time_step) as f32,
            stiffness: factors.stiffness as f32,
            tension: factors.added_by_tension() as f32,
            has_offsets: u32::from(!start.pose_offsets.is_empty()),
            ..BatchState::default()
        }
    }

    /// That there is room for the colliders of a start, and for their meshes, which are sent where they are new.
    fn check_colliders(&mut self, start: &StepStart<'_>) -> Result<()> {
        if start.colliders.len() > self.options.colliders {
            return Err(GpuError::Limit {
                what: "colliders of an instance".to_owned(),
                needed: start.colliders.len() as u64,
                limit: self.options.colliders as u64,
                cure: "raise GpuOptions::colliders",
            }
            .into());
        }
        for collider in start.colliders {
            self.buffers.grids.index(&self.queue, collider)?;
        }
        Ok(())
    }

    fn upload_colliders(&mut self, i: usize, start: &StepStart<'_>) -> Result<()> {
        let origin = start.current.frames[0].position;
        let first = i * self.options.colliders;
        for end in [false, true] {
            self.colliders.clear();
            for collider in start.colliders {
                let grid = self.buffers.grids.index(&self.queue, collider)?;
                let friction = start.factors.friction;
                (self.colliders).push(pack::collider(collider, friction, origin, end, grid));
            }
            let buffer = match end {
                false => &self.buffers.common.previous_colliders,
                true => &self.buffers.common.colliders,
            };
            buffer.write(&self.queue, first, &self.colliders);
        }
        Ok(())
    }

    /// Sends the starts' frames and handles, each to its instance's slot, and their pasts.
    fn upload_starts(&self) {
        let (space, buffers) = (self.avatar.space(), &self.buffers.common);
        let frames = self.frames.chunks(space.frames.max(1));
        for (state, frames) in self.batch.iter().zip(frames) {
            let first = state.slot as usize * space.frames;
            buffers.frames.write(&self.queue, first, frames);
        }
        let past = self.past_frames.chunks(space.frames.max(1));
        for (state, past) in self.batch.iter().zip(past) {
            let first = state.instance as usize * space.frames;
            buffers.past_frames.write(&self.queue, first, past);
        }
        let past = self.past_handles.chunks(space.handles.max(1));
        for (state, past) in self.batch.iter().zip(past) {
            let first = state.instance as usize * space.handles;
            buffers.past_handles.write(&self.queue, first, past);
        }
        let handles = self.handles.chunks(space.handles.max(1));
        for (state, handles) in self.batch.iter().zip(handles) {
            let first = state.slot as usize * space.handles;
            buffers.handles.write(&self.queue, first, handles);
        }
    }

    /// Whether every state of the batch has the pose features that its instance was last posed with.
    fn is_posed(&self) -> bool {
        if self.features.is_empty() || self.batch.is_empty() {
            return false;
        }
        let features = self.features.len() / self.batch.len();
        (self.batch.iter())
            .zip(self.features.chunks_exact(features))
            .all(|(state, features)| self.posed_features[state.instance as usize] == features)
    }

    /// Takes x̄ of the posed skin over for the instances of the batch.
    fn copy_posed_rest(&self, submission: &mut Submission) {
        let bytes = 16 * self.avatar.skin.len() as u64;
        let (from, to) = (
            self.buffers.common.posed_skin_unposed.raw(),
            self.buffers.skin.unposed.raw(),
        );
        for state in &self.batch {
            let at = u64::from(state.instance) * bytes;
            (submission.encoder()).copy_buffer_to_buffer(from, at, to, at, bytes);
        }
    }
}
