//! The posed skin on the GPU.

use super::dispatch::Batch;
use super::potential::GpuPotential;
use super::shared::{BatchState, SkinVertex};
use super::stage::Stage;
use crate::Result;
use crate::model::State;
use glam::{DVec3, Vec3};

/// Positions and normals of every instance's skin, into the buffer that is drawn from.
pub(super) async fn pose_skin(potential: &mut GpuPotential, states: &[State]) -> Result<()> {
    potential.checks.poses(states)?;
    let instances = potential.starts.len();
    potential.clear_uploads();
    for (i, state) in states.iter().enumerate() {
        let batch_state = BatchState {
            instance: i as u32,
            slot: (instances + i) as u32,
            ..BatchState::default()
        };
        let origin = state.frames[0].position;
        potential.skin_origins[i] = origin;
        potential.push_state(batch_state, state, state, origin);
        let first = potential.features.len();
        potential.push_features(state);
        potential.posed_features[i].clear();
        potential.posed_features[i].extend_from_slice(&potential.features[first..]);
    }
    (potential.buffers.common.pose_features).write(&potential.queue, 0, &potential.features);
    potential.upload(instances);
    let batch = Batch::whole(instances);
    potential.submit(
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
pub(super) async fn read_skin(
    potential: &mut GpuPotential,
    instance: usize,
    positions: &mut Vec<DVec3>,
    normals: &mut Vec<DVec3>,
) -> Result<()> {
    potential.checks.instance(instance)?;
    let range = potential.skin_range(instance);
    let bytes = range.end - range.start;
    if bytes == 0 {
        positions.clear();
        normals.clear();
        return Ok(());
    }
    potential.submit(
        |_, _| {},
        |encoder| (potential.skin_readback).record(encoder, potential.skin_buffer(), range, 0),
    );
    let origin = potential.skin_origins[instance];
    let unpack = |bytes: &[u8]| {
        positions.clear();
        normals.clear();
        for bytes in bytes.chunks_exact(size_of::<SkinVertex>()) {
            let vertex: SkinVertex = bytemuck::pod_read_unaligned(bytes);
            positions.push(origin + Vec3::from_array(vertex.position).as_dvec3());
            normals.push(Vec3::from_array(vertex.normal).as_dvec3());
        }
    };
    potential
        .skin_readback
        .read(&potential.device, bytes, unpack)
        .await
}
