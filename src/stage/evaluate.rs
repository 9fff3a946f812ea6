//! The potential on the GPU: how Newton sees it.

use super::potential::{GpuPotential, Start};
use super::shared::{BatchState, SkinVertex, Summary};
use super::{Batch, upload};
use crate::model::{State, pose_feature};
use crate::potential::{BlockPattern, Energies, Evaluation, Potential, StepStart, Trial};
use crate::{Error, GpuError, Result};
use glam::{DVec3, Vec3};

impl GpuPotential {
    fn check_length(&self, field: &str, length: usize) -> Result<()> {
        let instances = self.starts.len();
        if length == instances {
            return Ok(());
        }
        Err(Error::invalid(
            field,
            format!("{length} given for {instances} instances"),
        ))
    }

    fn check_state(&self, state: &State) -> Result<()> {
        if state.space() != self.avatar.space() {
            return Err(Error::invalid("state", "is of another avatar"));
        }
        if !state.is_finite() {
            return Err(Error::NotFinite { quantity: "state" });
        }
        Ok(())
    }

    fn start(&self, instance: usize) -> Result<&Start> {
        (self.starts.get(instance))
            .and_then(Option::as_ref)
            .ok_or_else(|| {
                Error::invalid(
                    "instance",
                    format!("{instance} has not begun a step; call begin_step first"),
                )
            })
    }

    fn clear_uploads(&mut self) {
        self.batch.clear();
        self.frames.clear();
        self.handles.clear();
        self.features.clear();
    }

    /// Appends a state to the uploads.
    fn push(&mut self, header: BatchState, base: &State, state: &State, origin: DVec3) {
        let skeleton = &self.avatar.skeleton;
        self.batch.push(header);
        (self.frames).extend(upload::frames(skeleton, base, state, origin));
        self.handles.extend(upload::handles(base, state));
    }

    fn push_features(&mut self, state: &State) {
        if self.buffers.features.is_empty() {
            return;
        }
        let feature = pose_feature(&self.avatar.skeleton.parents, &state.frames);
        self.features.extend(feature.iter().map(|&f| f as f32));
    }

    /// Whether every state of the batch has the pose features that its instance was last drawn with.
    fn is_drawn(&self) -> bool {
        if self.features.is_empty() || self.batch.is_empty() {
            return false;
        }
        let features = self.features.len() / self.batch.len();
        (self.batch.iter())
            .zip(self.features.chunks_exact(features))
            .all(|(state, features)| self.drawn_features[state.instance as usize] == features)
    }

    /// Takes x̄ of the drawn skin over for the instances of the batch.
    fn copy_drawn_rest(&self) {
        let bytes = 16 * self.avatar.skin.len() as u64;
        let mut encoder = self.device.create_command_encoder(&Default::default());
        for state in &self.batch {
            let at = u64::from(state.instance) * bytes;
            let (from, to) = (&self.buffers.drawn_unposed, &self.buffers.skin.unposed);
            encoder.copy_buffer_to_buffer(from.raw(), at, to.raw(), at, bytes);
        }
        self.queue.submit([encoder.finish()]);
    }

    /// Sends the uploads; states go to consecutive slots from `slot` on.
    fn upload(&self, slot: usize) {
        let space = self.avatar.space();
        self.buffers.batch.write(&self.queue, 0, &self.batch);
        (self.buffers.frames).write(&self.queue, slot * space.frames, &self.frames);
        (self.buffers.handles).write(&self.queue, slot * space.handles, &self.handles);
    }
}

impl Potential for GpuPotential {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn space(&self) -> crate::model::Space {
        self.avatar.space()
    }

    fn pattern(&self) -> &BlockPattern {
        &self.pattern
    }

    fn instances(&self) -> usize {
        self.starts.len()
    }

    async fn begin_step(&mut self, starts: &[StepStart<'_>], active: &[bool]) -> Result<()> {
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
            start.colliders.iter().try_for_each(|c| c.validate())?;
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
                ..BatchState::default()
            };
            self.colliders.clear();
            (self.colliders).extend(start.colliders.iter().map(|c| upload::collider(c, origin)));
            let first = i * self.options.colliders;
            (self.buffers.colliders).write(&self.queue, first, &self.colliders);

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
            });
        }
        (self.buffers.features).write(&self.queue, 0, &self.features);
        let batch = Batch {
            chunk: 0,
            states: self.batch.len() as u32,
        };
        let damped = self.avatar.damping_time > 0.0;
        // Usually a step starts from the pose that was just drawn: then x̄ of the skin is there already.
        let drawn = self.is_drawn();
        if drawn {
            self.copy_drawn_rest();
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
            },
            |_| {},
        );
        Ok(())
    }

    async fn evaluate(
        &mut self,
        states: &[State],
        active: &[bool],
        out: &mut [Evaluation],
    ) -> Result<()> {
        self.check_length("states", states.len())?;
        self.check_length("active", active.len())?;
        self.check_length("out", out.len())?;
        let instances = self.starts.len();
        self.clear_uploads();
        for (i, state) in states.iter().enumerate().filter(|(i, _)| active[*i]) {
            self.check_state(state)?;
            let Start {
                origin,
                current,
                header,
            } = self.start(i)?.clone();
            let header = BatchState {
                slot: (instances + self.batch.len()) as u32,
                base: i as u32,
                ..header
            };
            self.push(header, &current, state, origin);
        }
        let count = self.batch.len();
        if count == 0 {
            return Ok(());
        }
        self.upload(instances);
        let summary_bytes = (count * size_of::<Summary>()) as u64;
        let stride = self.buffers.result_stride;
        let bytes = summary_bytes + (4 * count * stride) as u64;
        self.submit(
            |stages, pass| {
                for batch in self.chunks(count) {
                    stages.displacement.dispatch(pass, batch);
                    stages.elasticity.dispatch(pass, batch);
                    stages.contact.dispatch(pass, batch);
                    stages.compact.dispatch(pass, batch);
                    stages.gradient.dispatch(pass, batch);
                    stages.point_hessian.dispatch(pass, batch);
                    stages.hessian.dispatch(pass, batch);
                    stages.energy.dispatch(pass, batch);
                }
            },
            |encoder| {
                let summaries = self.buffers.summaries.raw();
                (self.readback).record(encoder, summaries, 0..summary_bytes, 0);
                let result = self.buffers.result.raw();
                let range = 0..bytes - summary_bytes;
                (self.readback).record(encoder, result, range, summary_bytes);
            },
        );
        let (dofs, capacity) = (self.space().dofs(), self.options.contacts);
        let batch = &self.batch;
        let unpack = |bytes: &[u8]| {
            let (summaries, results) = bytes.split_at(summary_bytes as usize);
            let mut found = Vec::with_capacity(count);
            for (header, bytes) in batch
                .iter()
                .zip(summaries.chunks_exact(size_of::<Summary>()))
            {
                let summary: Summary = bytemuck::pod_read_unaligned(bytes);
                check_contacts(&summary, header.instance, capacity)?;
                found.push(summary);
            }
            if !results.chunks_exact(4).all(|b| float(b).is_finite()) {
                return Err(Error::NotFinite {
                    quantity: "gradient or Hessian of the tissue",
                });
            }
            for (b, summary) in found.iter().enumerate() {
                let evaluation = &mut out[batch[b].instance as usize];
                evaluation.energies = energies(summary)?;
                evaluation.contact_force = Vec3::from_array(summary.energy.force).as_dvec3();
                evaluation.contacts = summary.contacts as usize;
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
            }
            Ok(())
        };
        self.readback.read(&self.device, bytes, unpack).await?
    }

    async fn energy_differences(&mut self, trials: &[Trial<'_>], out: &mut [f64]) -> Result<()> {
        if trials.len() != out.len() {
            return Err(Error::invalid("out", "must be as long as the trials"));
        }
        let instances = self.starts.len();
        let most = self.options.trials.max(1);
        for (trials, out) in trials.chunks(most).zip(out.chunks_mut(most)) {
            self.clear_uploads();
            // First the trials, then the bases they are measured from, each base once.
            let mut bases: Vec<&Trial<'_>> = Vec::new();
            for trial in trials {
                self.check_state(trial.base)?;
                self.check_state(trial.state)?;
                let Start { origin, header, .. } = self.start(trial.instance)?.clone();
                let base = bases
                    .iter()
                    .position(|b| b.instance == trial.instance && b.base == trial.base)
                    .unwrap_or_else(|| {
                        bases.push(trial);
                        bases.len() - 1
                    });
                let header = BatchState {
                    slot: (instances + self.batch.len()) as u32,
                    base: (instances + trials.len() + base) as u32,
                    ..header
                };
                self.push(header, trial.base, trial.state, origin);
            }
            for trial in bases {
                let Start {
                    origin,
                    current,
                    header,
                } = self.start(trial.instance)?.clone();
                let header = BatchState {
                    slot: (instances + self.batch.len()) as u32,
                    base: header.instance,
                    ..header
                };
                self.push(header, &current, trial.base, origin);
            }
            self.upload(instances);
            let batch = |states: usize| Batch {
                chunk: 0,
                states: states as u32,
            };
            let bytes = (trials.len() * size_of::<Summary>()) as u64;
            self.submit(
                |stages, pass| {
                    stages.displacement.dispatch(pass, batch(self.batch.len()));
                    stages.contact.dispatch(pass, batch(self.batch.len()));
                    stages.energy.dispatch(pass, batch(trials.len()));
                },
                |encoder| {
                    let summaries = self.buffers.summaries.raw();
                    self.readback.record(encoder, summaries, 0..bytes, 0);
                },
            );
            let unpack = |bytes: &[u8]| {
                let summaries = bytes.chunks_exact(size_of::<Summary>());
                for (out, bytes) in out.iter_mut().zip(summaries) {
                    *out = energies(&bytemuck::pod_read_unaligned(bytes))?.total();
                }
                Ok::<(), Error>(())
            };
            self.readback.read(&self.device, bytes, unpack).await??;
        }
        Ok(())
    }

    async fn pose_skin(&mut self, states: &[State]) -> Result<()> {
        self.check_length("states", states.len())?;
        let instances = self.starts.len();
        self.clear_uploads();
        for (i, state) in states.iter().enumerate() {
            self.check_state(state)?;
            let header = BatchState {
                instance: i as u32,
                slot: (instances + i) as u32,
                ..BatchState::default()
            };
            let origin = state.frames[0].position;
            self.skin_origins[i] = origin;
            self.push(header, state, state, origin);
            let first = self.features.len();
            self.push_features(state);
            self.drawn_features[i].clear();
            self.drawn_features[i].extend_from_slice(&self.features[first..]);
        }
        (self.buffers.features).write(&self.queue, 0, &self.features);
        self.upload(instances);
        let batch = Batch {
            chunk: 0,
            states: instances as u32,
        };
        self.submit(
            |stages, pass| {
                stages.pose_blend.dispatch_drawn(pass, batch);
                stages.skin.dispatch(pass, batch);
                stages.normals.dispatch(pass, batch);
            },
            |_| {},
        );
        Ok(())
    }

    async fn read_skin(
        &mut self,
        instance: usize,
        positions: &mut Vec<DVec3>,
        normals: &mut Vec<DVec3>,
    ) -> Result<()> {
        if instance >= self.starts.len() {
            return Err(Error::invalid(
                "instance",
                format!("{instance} is not there"),
            ));
        }
        let range = self.skin_range(instance);
        let bytes = range.end - range.start;
        if bytes == 0 {
            positions.clear();
            normals.clear();
            return Ok(());
        }
        self.submit(
            |_, _| {},
            |encoder| (self.skin_readback).record(encoder, self.skin_buffer(), range, 0),
        );
        let origin = self.skin_origins[instance];
        let unpack = |bytes: &[u8]| {
            positions.clear();
            normals.clear();
            for bytes in bytes.chunks_exact(size_of::<SkinVertex>()) {
                let vertex: SkinVertex = bytemuck::pod_read_unaligned(bytes);
                positions.push(origin + Vec3::from_array(vertex.position).as_dvec3());
                normals.push(Vec3::from_array(vertex.normal).as_dvec3());
            }
        };
        self.skin_readback.read(&self.device, bytes, unpack).await
    }
}

fn float(bytes: &[u8]) -> f32 {
    bytemuck::pod_read_unaligned(bytes)
}

fn check_contacts(summary: &Summary, instance: u32, capacity: usize) -> Result<()> {
    if summary.contacts as usize <= capacity {
        return Ok(());
    }
    Err(GpuError::Limit {
        what: format!("active contacts of instance {instance}"),
        needed: u64::from(summary.contacts),
        limit: capacity as u64,
        cure: "raise GpuOptions::contacts",
    }
    .into())
}

fn energies(summary: &Summary) -> Result<Energies> {
    let e = &summary.energy;
    let energies = Energies {
        inertia: e.inertia.into(),
        gravity: e.gravity.into(),
        elastic: e.elastic.into(),
        damping: e.damping.into(),
        contact: e.contact.into(),
    };
    if energies.total().is_finite() && e.force.iter().all(|f| f.is_finite()) {
        return Ok(energies);
    }
    Err(Error::NotFinite {
        quantity: "energy of the tissue",
    })
}
