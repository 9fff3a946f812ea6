//! The drawn skin on the GPU.

use super::Batch;
use super::potential::GpuPotential;
use super::shared::{BatchState, SkinVertex};
use crate::model::State;
use crate::{Error, Result};
use glam::{DVec3, Vec3};

impl GpuPotential {
    /// Positions and normals of every instance's skin, into the buffer that is drawn from.
    pub(super) async fn draw(&mut self, states: &[State]) -> Result<()> {
        self.check_length("states", states.len())?;
        states.iter().try_for_each(|s| self.check_state(s))?;
        let instances = self.starts.len();
        self.clear_uploads();
        for (i, state) in states.iter().enumerate() {
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
            self.posed_features[i].clear();
            self.posed_features[i].extend_from_slice(&self.features[first..]);
        }
        (self.buffers.features).write(&self.queue, 0, &self.features);
        self.upload(instances);
        let batch = Batch {
            chunk: 0,
            states: instances as u32,
        };
        self.submit(
            |stages, pass| {
                stages.pose_blend.dispatch_posed_skin(pass, batch);
                stages.skin.dispatch(pass, batch);
                stages.normals.dispatch(pass, batch);
            },
            |_| {},
        );
        Ok(())
    }

    /// Copies an instance's skin out of it.
    pub(super) async fn read_posed_skin(
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
