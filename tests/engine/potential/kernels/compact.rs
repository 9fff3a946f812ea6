//! Kernel compact: the rows of the active contacts, and the rows of each block.

use super::INSTANCE;
use super::bound::{Comparison, LENGTH, Outcome, QUOTIENT, abs, abs_cross};
use super::contact::{candidate, distances};
use super::friction::{slid, smoothing};
use super::points::{abs_position, minus_joints, skin_roundings};
use super::scene::{OPTIONS_CONTACTS, Phase, Scene, vec};
use supple::glam::DVec3;
use supple::internal::cpu::contact::{
    Candidate, ContactRow, body_levers, contact_point, skin_levers,
};
use supple::internal::cpu::displacement::{arms, blended_rotation, unposed_displacement};
use supple::internal::cpu::{compact as compact_twin, friction as friction_twin};
use supple::internal::features::point_blocks;
use supple::internal::gpu::shared;

/// The rows of the evaluated state, as the device listed them.
pub fn listed(scene: &Scene) -> Vec<ContactRow> {
    let room = 3 * OPTIONS_CONTACTS + 1;
    let mut list: Vec<shared::Contact> = scene.items(Phase::Evaluated, "contacts", INSTANCE, room);
    let count = list.remove(0).body as usize;
    list.truncate(count);
    list.iter()
        .map(|c| ContactRow {
            vertex: c.vertex,
            body: c.body.checked_sub(1),
            direction: vec(c.direction),
            force: f64::from(c.force),
            stiffness: f64::from(c.stiffness),
        })
        .collect()
}

/// Blocks of skin vertex `v` in its own order.
pub fn vertex_blocks(scene: &Scene, v: usize) -> Vec<u32> {
    let mut blocks = Vec::new();
    point_blocks(scene.avatar.space(), &scene.avatar.skin, v, &mut blocks);
    blocks
}

/// Places of a row: the longest vertex's and a body's.
fn row_length(scene: &Scene) -> usize {
    let set = &scene.avatar.skin;
    let lengths = (0..set.len()).map(|v| vertex_blocks(scene, v).len());
    lengths.max().unwrap_or(0) + 2
}

/// (block, place) of everything that a row moves: the vertex's own, and the body's in the last places.
pub fn places(scene: &Scene, contact: &ContactRow) -> Vec<(u32, usize)> {
    let last = row_length(scene) - 2;
    let own = vertex_blocks(scene, contact.vertex as usize);
    let body = contact.body.into_iter();
    let body = body.flat_map(|c| [(2 * c, last), (2 * c + 1, last + 1)]);
    own.into_iter().zip(0..).chain(body).collect()
}

/// Jᵀe of a listed row, by place.
pub fn rows(scene: &Scene, contact: usize) -> Vec<DVec3> {
    let stride = row_length(scene);
    let index = INSTANCE * 3 * OPTIONS_CONTACTS + contact;
    let rows: Vec<[f32; 4]> = scene.items(Phase::Evaluated, "contact_rows", index, stride);
    rows.iter().map(|r| vec([r[0], r[1], r[2]])).collect()
}

/// Friction's slopes, with |u|/|u_T|: the cancellation in u_T (5), a length, and a polynomial (3) of a quotient over another.
const SLOPES: usize = 5 + LENGTH + 3 + 2 * QUOTIENT;

/// The list is exact but for k a and k a δ (two roundings) and friction's [`SLOPES`]. Rows: T (n_h + 2), T − J, a row of R (3), w, a cross product
/// (2); or Rᵀe (3), w, the sum over bones, U; or the point (as the skin's), x − c and a cross product.
pub fn compact(scene: &Scene) -> Outcome {
    let phase = Phase::Evaluated;
    let all = distances(scene, phase, phase.slot());
    let candidates: Vec<Candidate> = all.iter().map(candidate).collect();
    let mut want = Vec::new();
    let (stiffness, colliders) = (|v, c| scene.contact_stiffness(v, c), &scene.colliders);
    let active = compact_twin::compact(&candidates, stiffness, colliders, &mut want);
    let lagged = slid(scene, phase, phase.slot(), None);
    for [_, (contact, slip)] in &lagged {
        want.extend(friction_twin::rows(contact, slip, smoothing()));
    }
    let got = listed(scene);
    if active == 0 || active > OPTIONS_CONTACTS || lagged.is_empty() {
        return Err(format!(
            "{active} contacts: the scene must have some, and room for them"
        ));
    }
    let key = |c: &ContactRow| (c.vertex, c.body);
    if got.len() != want.len() || !got.iter().map(key).eq(want.iter().map(key)) {
        return Err(format!(
            "{} rows listed, the twin has {}",
            got.len(),
            want.len()
        ));
    }
    if scene.evaluation.contacts != active {
        return Err(format!("{} contacts reported", scene.evaluation.contacts));
    }

    let mut out = Comparison::default();
    for (k, (got, want)) in got.iter().zip(&want).enumerate() {
        if k < active {
            out.vector(got.direction, want.direction, want.direction.abs(), 1);
            out.number(got.force, want.force, want.force.abs(), 2);
            out.number(got.stiffness, want.stiffness, want.stiffness, 1);
            continue;
        }
        let [_, (contact, slip)] = lagged[(k - active) / 2];
        let y = slip.length();
        let cancelled = 1.0 + slip.displacement.length() / y;
        let size = DVec3::splat(2.0 * cancelled);
        out.vector(got.direction, want.direction, size, SLOPES);
        out.number(got.force, want.force, contact.limit * cancelled, SLOPES);
        let slope = 4.0 * contact.limit / y.min(smoothing());
        out.number(got.stiffness, want.stiffness, slope * cancelled, SLOPES);
    }
    levers_agree(scene, &got, &mut out);
    block_lists(scene, &got)?;
    out.finish("f, k, e and Jᵀe")
}

fn levers_agree(scene: &Scene, listed: &[ContactRow], out: &mut Comparison) {
    let set = &scene.avatar.skin;
    let phase = Phase::Evaluated;
    let rest = scene.rest(phase, "skin_unposed", set);
    let frames = scene.frames(phase, phase.slot());
    let phi = scene.displaced(phase, phase.slot());
    let mut abs_frames = frames.clone();
    for frame in &mut abs_frames {
        frame.rotation = abs(frame.rotation);
    }
    let minus_joints = minus_joints(scene);
    for (k, contact) in listed.iter().enumerate() {
        let v = contact.vertex as usize;
        let (skinning, basis) = (set.skinning.row(v), set.basis.row(v));
        let t = rest[v] + unposed_displacement(basis, &phi);
        let blocks = 2 * skinning.len() + basis.len();
        let mut levers = vec![DVec3::ZERO; blocks];
        let (side, e) = ((skinning, basis), contact.direction);
        skin_levers(side, scene.joints(), &frames, t, e, &mut levers);
        let terms = basis
            .iter()
            .map(|u| u.value.abs() * phi[u.handle as usize].abs());
        let abs_t = rest[v].abs() + terms.sum::<DVec3>();
        let mut abs_arms = vec![DVec3::ZERO; skinning.len()];
        arms(skinning, &minus_joints, &abs_frames, abs_t, &mut abs_arms);
        let abs_e = e.abs();
        let pulled = blended_rotation(skinning, &abs_frames).transpose() * abs_e;
        let roundings = basis.len() + skinning.len() + 10;
        let got = rows(scene, k);
        for (b, row) in got[..blocks].iter().enumerate() {
            let magnitude = if b >= 2 * skinning.len() {
                basis[b - 2 * skinning.len()].value.abs() * pulled
            } else if b.is_multiple_of(2) {
                skinning[b / 2].weight * abs_e
            } else {
                abs_cross(abs_arms[b / 2], abs_e)
            };
            out.vector(*row, levers[b], magnitude, roundings);
        }
        if let Some(c) = contact.body {
            let body = &frames[c as usize];
            let point = contact_point(skinning, scene.joints(), &frames, t);
            let [translation, rotation] = body_levers(body, point, e);
            let last = got.len() - 2;
            out.vector(got[last], translation, abs_e, 1);
            let abs_p = abs_position(scene, phase, phase.slot(), set, v, rest[v]);
            let magnitude = abs_cross(abs_p + body.position.abs(), abs_e);
            let roundings = skin_roundings(set, v) + 4;
            out.vector(got[last + 1], rotation, magnitude, roundings);
        }
    }
}

/// Every block's rows, exactly.
fn block_lists(scene: &Scene, contacts: &[ContactRow]) -> Outcome {
    let blocks = scene.avatar.space().blocks();
    let places: Vec<_> = contacts.iter().map(|c| places(scene, c)).collect();
    for block in 0..blocks {
        let index = INSTANCE * blocks + block;
        let room = 3 * OPTIONS_CONTACTS + 1;
        let list: Vec<u32> = scene.items(Phase::Evaluated, "block_contacts", index, room);
        let want: Vec<u32> = (places.iter().enumerate())
            .filter_map(|(k, places)| {
                let (_, place) = places.iter().find(|(b, _)| *b as usize == block)?;
                Some((k * 256 + place) as u32)
            })
            .collect();
        if list[0] as usize != want.len() || list[1..=want.len()] != want {
            return Err(format!("contacts of block {block} differ"));
        }
    }
    Ok(())
}
