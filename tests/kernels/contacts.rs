//! Kernels of the contacts: contact, compact.

use super::INSTANCE;
use super::bound::{Comparison, Outcome, abs, abs_cross};
use super::points::{abs_position, skin_roundings};
use super::scene::{OPTIONS_COLLIDERS, OPTIONS_CONTACTS, Phase, Scene, vec};
use supple::glam::DVec3;
use supple::potential::point_blocks;
use supple::reference::contact::{Candidate, ContactRow, skin_levers};
use supple::reference::displacement::{arms, blended_rotation, unposed_displacement};
use supple::reference::{compact as compact_twin, contact as contact_twin};
use supple::stage::shared;

/// (n, δ) of every vertex at every collider of `slot`, vertex by vertex.
pub fn distances(scene: &Scene, phase: Phase, slot: usize) -> Vec<[f32; 4]> {
    let vertices = scene.avatar.skin.len();
    let mut all = scene.items(phase, "distances", slot, vertices * OPTIONS_COLLIDERS);
    all.truncate(vertices * scene.colliders.len());
    all
}

/// d is 1-Lipschitz: its error is that of the point in the collider's frame (as the skin's, p − c and a row of
/// R: 4) and of the shape's own lengths (12, square root and division being of 2.5 ulp). n turns by the
/// curvature ∇²d times the same, and is rotated back (3).
pub fn contact(scene: &Scene) -> Outcome {
    let mut out = Comparison::default();
    let set = &scene.avatar.skin;
    let phase = Phase::Evaluated;
    let rest = scene.rest(phase, "skin_unposed", set);
    for slot in [INSTANCE, phase.slot()] {
        let frames = scene.frames(phase, slot);
        let phi = scene.displaced(phase, slot);
        let got = distances(scene, phase, slot);
        for i in 0..set.len() {
            let (skinning, basis) = (set.skinning.row(i), set.basis.row(i));
            let t = rest[i] + unposed_displacement(basis, &phi);
            let p = contact_twin::contact_point(skinning, scene.joints(), &frames, t);
            let abs_p = abs_position(scene, phase, slot, set, i, rest[i]);
            for (k, collider) in scene.colliders.iter().enumerate() {
                // A vertex without an area touches nothing.
                let want = match set.measure[i] {
                    0.0 => Candidate::default(),
                    _ => contact_twin::contact(p, collider, &collider.frame),
                };
                let [x, y, z, depth] = got[i * scene.colliders.len() + k];
                let sizes = collider.shape.parameters().iter().sum::<f32>();
                let to_local = abs(collider.frame.rotation.transpose());
                let local = to_local * (abs_p + collider.frame.position.abs());
                let magnitude = local.element_sum() + f64::from(sizes) + collider.margin;
                let roundings = skin_roundings(set, i) + 4 + 12;
                out.number(f64::from(depth).max(0.0), want.depth, magnitude, roundings);
                let curvature = collider.curvature(&collider.frame, p).to_cols_array();
                let curvature = curvature.iter().map(|c| c * c).sum::<f64>().sqrt();
                let magnitude = DVec3::splat(2.0 + magnitude * curvature);
                out.vector(vec([x, y, z]), want.normal, magnitude, roundings + 3);
            }
        }
    }
    out.finish("δ and n")
}

/// The active contacts of the evaluated state, as the device listed them.
pub fn listed(scene: &Scene) -> Vec<ContactRow> {
    let mut list: Vec<shared::Contact> =
        scene.items(Phase::Evaluated, "contacts", INSTANCE, OPTIONS_CONTACTS + 1);
    let count = list.remove(0).vertex as usize;
    list.truncate(count);
    list.iter()
        .map(|c| ContactRow {
            vertex: c.vertex,
            carrier: None,
            direction: vec(c.normal),
            force: -f64::from(c.depth) * f64::from(c.stiffness),
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

/// Rows Jᵀn of the listed contacts, in the vertices' own order.
pub fn rows(scene: &Scene, contact: usize) -> Vec<DVec3> {
    let set = &scene.avatar.skin;
    let stride = (0..set.len()).map(|v| vertex_blocks(scene, v).len()).max();
    let stride = stride.unwrap_or(0);
    let index = INSTANCE * OPTIONS_CONTACTS + contact;
    let rows: Vec<[f32; 4]> = scene.items(Phase::Evaluated, "contact_rows", index, stride);
    rows.iter().map(|r| vec([r[0], r[1], r[2]])).collect()
}

/// The list is exact but for k a (one rounding). Rows: T (n_h + 2), T − J, a row of R (3), w, a cross
/// product (2); or Rᵀn (3), w, the sum over bones, U.
pub fn compact(scene: &Scene) -> Outcome {
    let set = &scene.avatar.skin;
    let phase = Phase::Evaluated;
    let candidates: Vec<Candidate> = distances(scene, phase, phase.slot())
        .iter()
        .map(|&[x, y, z, depth]| Candidate {
            depth: f64::from(depth),
            normal: vec([x, y, z]),
        })
        .collect();
    let mut want = Vec::new();
    let colliders = &scene.colliders;
    let active = compact_twin::compact(
        &candidates,
        &set.measure,
        colliders,
        OPTIONS_CONTACTS,
        &mut want,
    );
    let got = listed(scene);
    let unrounded = |c: &ContactRow| (c.vertex, c.carrier, c.direction.to_array());
    if active == 0 || active > OPTIONS_CONTACTS {
        return Err(format!(
            "{active} contacts: the scene must have some, and room for them"
        ));
    }
    if got.len() != active || !got.iter().map(unrounded).eq(want.iter().map(unrounded)) {
        return Err(format!(
            "{} contacts listed, the twin has {active}",
            got.len()
        ));
    }
    if scene.evaluation.contacts != active {
        return Err(format!("{} contacts reported", scene.evaluation.contacts));
    }

    let mut out = Comparison::default();
    let rest = scene.rest(phase, "skin_unposed", set);
    let frames = scene.frames(phase, phase.slot());
    let phi = scene.displaced(phase, phase.slot());
    let mut abs_frames = frames.clone();
    for frame in &mut abs_frames {
        frame.rotation = abs(frame.rotation);
    }
    let minus_joints = super::points::minus_joints(scene);
    for (k, (got, want)) in got.iter().zip(&want).enumerate() {
        out.number(got.stiffness, want.stiffness, want.stiffness, 1);
        out.number(got.force, want.force, want.force.abs(), 1);
        let v = want.vertex as usize;
        let (skinning, basis) = (set.skinning.row(v), set.basis.row(v));
        let t = rest[v] + unposed_displacement(basis, &phi);
        let blocks = 2 * skinning.len() + basis.len();
        let mut levers = vec![DVec3::ZERO; blocks];
        let side = (skinning, basis);
        skin_levers(side, scene.joints(), &frames, t, got.direction, &mut levers);
        let terms = basis
            .iter()
            .map(|u| u.value.abs() * phi[u.handle as usize].abs());
        let abs_t = rest[v].abs() + terms.sum::<DVec3>();
        let mut abs_arms = vec![DVec3::ZERO; skinning.len()];
        arms(skinning, &minus_joints, &abs_frames, abs_t, &mut abs_arms);
        let normal = got.direction.abs();
        let pulled = blended_rotation(skinning, &abs_frames).transpose() * normal;
        let roundings = basis.len() + skinning.len() + 10;
        for (b, row) in rows(scene, k)[..blocks].iter().enumerate() {
            let magnitude = if b >= 2 * skinning.len() {
                basis[b - 2 * skinning.len()].value.abs() * pulled
            } else if b.is_multiple_of(2) {
                skinning[b / 2].weight * normal
            } else {
                abs_cross(abs_arms[b / 2], normal)
            };
            out.vector(*row, levers[b], magnitude, roundings);
        }
    }
    block_lists(scene, &got)?;
    out.finish("k a and Jᵀn")
}

/// Every block's contacts, exactly.
fn block_lists(scene: &Scene, contacts: &[ContactRow]) -> Outcome {
    let blocks = scene.avatar.space().blocks();
    for block in 0..blocks {
        let index = INSTANCE * blocks + block;
        let list: Vec<u32> = scene.items(
            Phase::Evaluated,
            "block_contacts",
            index,
            OPTIONS_CONTACTS + 1,
        );
        let want: Vec<u32> = (contacts.iter().enumerate())
            .filter_map(|(k, c)| {
                let place = vertex_blocks(scene, c.vertex as usize)
                    .iter()
                    .position(|&b| b as usize == block)?;
                Some((k * 256 + place) as u32)
            })
            .collect();
        if list[0] as usize != want.len() || list[1..=want.len()] != want {
            return Err(format!("contacts of block {block} differ"));
        }
    }
    Ok(())
}
