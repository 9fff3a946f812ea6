//! The geometric terms of contact on the GPU's way: the rows of the active contacts are read back, and
//! [`crate::potential::cpu::geometric`] assembles their terms in f64.

use super::recorder::{Recorder, Start};
use super::shared::Contact;
use crate::model::State;
use crate::potential::cpu::contact::ContactRow;
use crate::potential::cpu::displacement::unposed_displacement;
use crate::potential::cpu::geometric::{Vertex, add_geometric};
use crate::potential::cpu::pose_blend::{add_offsets, pose_blend};
use glam::{DVec3, Vec3};

/// The terms of the rows in `contacts`, as read back, at `state`; none where the step did not ask for them.
pub(super) fn geometric_terms(
    recorder: &Recorder,
    start: &Start,
    state: &State,
    contacts: &[u8],
    out: &mut Vec<[f64; 9]>,
) {
    out.clear();
    let Some(of_skin) = &start.geometric else {
        return;
    };
    out.resize(recorder.pattern.len(), [0.0; 9]);
    let (skin, joints) = (&recorder.avatar.skin, &recorder.avatar.skeleton.joints);
    let (_, rows) = contact_rows(contacts, skin.len());
    // A device that went wrong may bring anything.
    let frames = state.frames.len() as u32;
    let exists = |row: &ContactRow| row.body.is_none_or(|body| body < frames);
    for row in rows.filter(|row| row.force != 0.0 && exists(row)) {
        let v = row.vertex as usize;
        let mut rest = [DVec3::ZERO];
        let (feature, offsets) = (&of_skin.feature, &of_skin.offsets);
        pose_blend(&skin.position, &skin.pose_blend, feature, v, &mut rest);
        add_offsets(&mut rest, offsets.get(v..).unwrap_or_default());
        let basis = skin.basis.row(v);
        let vertex = Vertex {
            skinning: skin.skinning.row(v),
            basis,
            fine: &[],
            unposed: rest[0] + unposed_displacement(basis, &state.handles),
        };
        let pattern = (&recorder.pattern, &start.prescribed[..]);
        add_geometric(pattern, &row, &vertex, joints, &state.frames, out);
    }
}

/// How many contacts were found, and the rows of those that there was room for, as read back. Rows of vertices that the
/// skin has not are left out: a device that went wrong may bring anything.
pub(super) fn contact_rows(
    bytes: &[u8],
    vertices: usize,
) -> (usize, impl Iterator<Item = ContactRow>) {
    let mut rows = bytes
        .chunks_exact(size_of::<Contact>())
        .map(bytemuck::pod_read_unaligned::<Contact>);
    let header = rows.next().unwrap_or_default();
    let rows = rows.take(header.body as usize);
    let rows = rows.filter(move |row| (row.vertex as usize) < vertices);
    let row = |row: Contact| ContactRow {
        vertex: row.vertex,
        body: row.body.checked_sub(1),
        direction: Vec3::from_array(row.direction).as_dvec3(),
        force: row.force.into(),
        stiffness: row.stiffness.into(),
    };
    (header.vertex as usize, rows.map(row))
}
