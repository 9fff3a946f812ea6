//! Kernels of the contacts: contact, friction, compact.

use super::INSTANCE;
use super::bound::{Comparison, Outcome, abs, abs_cross};
use super::points::{abs_position, minus_joints, skin_roundings};
use super::scene::{
    OPTIONS_COLLIDERS, OPTIONS_CONTACTS, Phase, SLIP_SPEED, Scene, TIME_STEP, mat, vec,
};
use supple::collider::Collider;
use supple::glam::{DMat3, DVec3};
use supple::model::Frame;
use supple::potential::point_blocks;
use supple::reference::contact::{
    Candidate, ContactRow, carrier_levers, contact_point, may_touch, skin_levers,
};
use supple::reference::displacement::{
    FrameMotion, arms, blended_rotation, displacement, unposed_displacement,
};
use supple::reference::friction::{self as friction_twin, Lagged, Slip};
use supple::reference::{compact as compact_twin, contact as contact_twin};
use supple::stage::shared;

/// ε, m.
pub fn smoothing() -> f64 {
    f64::from((SLIP_SPEED * TIME_STEP) as f32)
}

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
            let p = contact_point(skinning, scene.joints(), &frames, t);
            let abs_p = abs_position(scene, phase, slot, set, i, rest[i]);
            for (k, collider) in scene.colliders.iter().enumerate() {
                let place = collider.place(&frames);
                // A vertex without an area touches nothing, nor one that moves with the collider.
                let touches = set.measure[i] > 0.0 && may_touch(skinning, collider);
                let want = match touches {
                    false => Candidate::default(),
                    true => contact_twin::contact(p, collider, &place),
                };
                let [x, y, z, depth] = got[i * scene.colliders.len() + k];
                let sizes = collider.shape.parameters().iter().sum::<f32>();
                let (to_local, abs_place) = abs_place(collider, &frames);
                let local = to_local.transpose() * (abs_p + abs_place);
                let magnitude = local.element_sum() + f64::from(sizes) + collider.margin;
                // A row of R_c R and of R_c p + c: 4 more.
                let roundings = skin_roundings(set, i) + 4 + 12 + 4;
                out.number(f64::from(depth).max(0.0), want.depth, magnitude, roundings);
                let curvature = collider.curvature(&place, p).to_cols_array();
                let curvature = curvature.iter().map(|c| c * c).sum::<f64>().sqrt();
                let magnitude = DVec3::splat(2.0 + magnitude * curvature);
                out.vector(vec([x, y, z]), want.normal, magnitude, roundings + 7);
            }
        }
    }
    out.finish("δ and n")
}

/// Rotation and position of a collider's place with all signs plus.
fn abs_place(collider: &Collider, frames: &[Frame]) -> (DMat3, DVec3) {
    let (r, p) = (abs(collider.frame.rotation), collider.frame.position.abs());
    match collider.carrier {
        None => (r, p),
        Some(c) => {
            let carrier = &frames[c as usize];
            let abs_carrier = abs(carrier.rotation);
            (abs_carrier * r, abs_carrier * p + carrier.position.abs())
        }
    }
}

/// (Place at tⁿ, its motion over the step) of the frames that the colliders are fixed to, as the device has them.
fn grounds(scene: &Scene) -> (Vec<Frame>, Vec<FrameMotion>) {
    let phase = Phase::Evaluated;
    let frames = scene.frames(phase, INSTANCE);
    let all: Vec<shared::Collider> =
        scene.items(phase, "previous_colliders", INSTANCE, OPTIONS_COLLIDERS);
    let ground = |(collider, c): (&Collider, &shared::Collider)| {
        let place = match collider.carrier {
            None => Frame {
                rotation: mat(c.rotation),
                position: vec(c.position),
            },
            Some(carrier) => frames[carrier as usize],
        };
        let motion = FrameMotion {
            rotation: place.rotation + mat(c.rotation_change),
            rotation_change: mat(c.rotation_change),
            translation_change: vec(c.position_change),
        };
        (place, motion)
    };
    scene.colliders.iter().zip(&all).map(ground).unzip()
}

fn lagged(scene: &Scene) -> Vec<shared::Lagged> {
    let mut list: Vec<shared::Lagged> =
        scene.items(Phase::Evaluated, "lagged", INSTANCE, OPTIONS_CONTACTS + 1);
    let count = list.remove(0).vertex as usize;
    list.truncate(count);
    list
}

/// A record of the device as the twin's, but that n is in world axes where the collider's motion is given.
fn unpacked(c: &shared::Lagged) -> Lagged {
    Lagged {
        vertex: c.vertex,
        collider: c.collider,
        carrier: c.carrier.checked_sub(1),
        anchor: vec(c.anchor),
        normal: vec(c.normal),
        limit: f64::from(c.limit),
    }
}

/// The lagged list, exact but for μ k a δ (3); a: the point (as the skin's), p − c and a row of R (4); n: two
/// rows of R; u at qⁿ: a row of ΔR and a sum more. The slips: as the displacement's, and a row of ΔR and a sum.
pub fn friction(scene: &Scene) -> Outcome {
    let phase = Phase::Evaluated;
    let set = &scene.avatar.skin;
    let colliders = &scene.colliders;
    let mut old: Vec<[f32; 4]> = scene.items(
        phase,
        "lagged_distances",
        INSTANCE,
        set.len() * OPTIONS_COLLIDERS,
    );
    old.truncate(set.len() * colliders.len());
    let candidates: Vec<Candidate> = old.iter().map(candidate).collect();
    let (places, motions) = grounds(scene);
    let frames = scene.frames(phase, INSTANCE);
    let phi = scene.displaced(phase, INSTANCE);
    let rest = scene.rest(phase, "skin_unposed", set);
    let point = |v: usize| {
        let t = rest[v] + unposed_displacement(set.basis.row(v), &phi);
        contact_point(set.skinning.row(v), scene.joints(), &frames, t)
    };
    let mut want = Vec::new();
    compact_twin::lag(
        &candidates,
        &set.measure,
        colliders,
        &places,
        point,
        &mut want,
    );
    let got = lagged(scene);
    let key = |l: &Lagged| (l.vertex, l.collider, l.carrier);
    if want.len() < 20
        || !got
            .iter()
            .map(|g| key(&unpacked(g)))
            .eq(want.iter().map(key))
    {
        return Err(format!("{} lagged, the twin has {}", got.len(), want.len()));
    }
    let mut out = Comparison::default();
    for (got, want) in got.iter().zip(&want) {
        let (k, v) = (want.collider as usize, want.vertex as usize);
        // Three products; |∇d| is a square root (5) of three squares, whose roundings (3) it halves.
        out.number(f64::from(got.limit), want.limit, want.limit, 10);
        let abs_rotation = abs(places[k].rotation);
        let abs_p = abs_position(scene, phase, INSTANCE, set, v, rest[v]);
        let abs_anchor = abs_rotation.transpose() * (abs_p + places[k].position.abs());
        let roundings = skin_roundings(set, v) + 4;
        out.vector(vec(got.anchor), want.anchor, abs_anchor, roundings);
        // Of unit length, which takes 7 for the length and 3 for the quotient.
        let abs_normal = candidates[v * colliders.len() + k].normal.normalize().abs();
        let abs_normal = abs_rotation.transpose() * abs_normal;
        if want.carrier.is_some() {
            out.vector(vec(got.normal), want.normal, abs_normal, 13);
            continue;
        }
        let motion = &motions[k];
        let abs_change = abs(motion.rotation_change);
        let normal = motion.rotation * want.normal;
        out.vector(
            vec(got.normal),
            normal,
            (abs_rotation + abs_change) * abs_normal,
            18,
        );
        let magnitude = abs_change * abs_anchor + motion.translation_change.abs();
        let start = -friction_twin::carried(want, motion);
        out.vector(vec(got.start), start, magnitude, roundings + 4);
    }
    slips_agree(scene, &got, &mut out)?;
    out.finish("friction")
}

fn candidate(&[x, y, z, depth]: &[f32; 4]) -> Candidate {
    Candidate {
        depth: f64::from(depth),
        normal: vec([x, y, z]),
    }
}

fn slips(scene: &Scene, phase: Phase, slot: usize) -> Vec<DVec3> {
    let all: Vec<[f32; 4]> = scene.items(phase, "slips", slot, OPTIONS_CONTACTS);
    all.iter().map(|s| vec([s[0], s[1], s[2]])).collect()
}

fn slips_agree(scene: &Scene, got: &[shared::Lagged], out: &mut Comparison) -> Outcome {
    let set = &scene.avatar.skin;
    let rest = scene.rest(Phase::Evaluated, "skin_unposed", set);
    for phase in [Phase::Evaluated, Phase::Compared] {
        let slot = phase.slot();
        let motions = scene.motions(phase, slot);
        let abs_motions: Vec<FrameMotion> = (motions.iter())
            .map(|m| FrameMotion {
                rotation: abs(m.rotation),
                rotation_change: abs(m.rotation_change),
                translation_change: m.translation_change.abs(),
            })
            .collect();
        let (phi, change) = scene.handles(phase, slot);
        let all = slips(scene, phase, slot);
        for (record, &slip) in got.iter().zip(&all) {
            let contact = unpacked(record);
            let v = contact.vertex as usize;
            let (skinning, basis) = (set.skinning.row(v), set.basis.row(v));
            let t = rest[v] + unposed_displacement(basis, &phi);
            let dt = unposed_displacement(basis, &change);
            let mut want = displacement(skinning, scene.joints(), &motions, t, dt);
            let abs_of = |handles: &[DVec3]| -> DVec3 {
                let terms = basis.iter();
                terms
                    .map(|u| u.value.abs() * handles[u.handle as usize].abs())
                    .sum()
            };
            let (abs_t, abs_dt) = (rest[v].abs() + abs_of(&phi), abs_of(&change));
            let joints = minus_joints(scene);
            let mut magnitude = displacement(skinning, &joints, &abs_motions, abs_t, abs_dt);
            if let Some(c) = contact.carrier {
                want -= friction_twin::carried(&contact, &motions[c as usize]);
                let anchor = Lagged {
                    anchor: contact.anchor.abs(),
                    ..contact
                };
                magnitude += friction_twin::carried(&anchor, &abs_motions[c as usize]);
            }
            out.vector(slip, want, magnitude, basis.len() + skinning.len() + 14);
        }
    }
    Ok(())
}

/// The lagged contacts with their u in a state and in its base, as energy and rows read them; `base` is none
/// for the step's start.
pub fn slid(
    scene: &Scene,
    phase: Phase,
    slot: usize,
    base: Option<usize>,
) -> Vec<[(Lagged, Slip); 2]> {
    let here = slips(scene, phase, slot);
    let frames = scene.frames(phase, slot);
    let before = base.map(|slot| (slips(scene, phase, slot), scene.frames(phase, slot)));
    let pair = |(k, record): (usize, &shared::Lagged)| {
        let contact = unpacked(record);
        let normal = |frames: &[Frame]| match contact.carrier {
            None => contact.normal,
            Some(c) => frames[c as usize].rotation * contact.normal,
        };
        let base = match &before {
            None => Slip {
                displacement: vec(record.start),
                normal: normal(&frames),
            },
            Some((slips, frames)) => Slip {
                displacement: vec(record.start) + slips[k],
                normal: normal(frames),
            },
        };
        let slip = Slip {
            displacement: base.displacement + here[k],
            normal: normal(&frames),
        };
        [(contact, base), (contact, slip)]
    };
    lagged(scene).iter().enumerate().map(pair).collect()
}

/// The rows of the evaluated state, as the device listed them.
pub fn listed(scene: &Scene) -> Vec<ContactRow> {
    let room = 3 * OPTIONS_CONTACTS + 1;
    let mut list: Vec<shared::Contact> = scene.items(Phase::Evaluated, "contacts", INSTANCE, room);
    let count = list.remove(0).carrier as usize;
    list.truncate(count);
    list.iter()
        .map(|c| ContactRow {
            vertex: c.vertex,
            carrier: c.carrier.checked_sub(1),
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

/// Places of a row: the longest vertex's and a carrier's.
fn row_length(scene: &Scene) -> usize {
    let set = &scene.avatar.skin;
    let lengths = (0..set.len()).map(|v| vertex_blocks(scene, v).len());
    lengths.max().unwrap_or(0) + 2
}

/// (block, place) of everything that a row moves: the vertex's own, and the carrier's in the last places.
pub fn places(scene: &Scene, contact: &ContactRow) -> Vec<(u32, usize)> {
    let last = row_length(scene) - 2;
    let own = vertex_blocks(scene, contact.vertex as usize);
    let carrier = contact.carrier.into_iter();
    let carrier = carrier.flat_map(|c| [(2 * c, last), (2 * c + 1, last + 1)]);
    own.into_iter().zip(0..).chain(carrier).collect()
}

/// Jᵀe of a listed row, by place.
pub fn rows(scene: &Scene, contact: usize) -> Vec<DVec3> {
    let stride = row_length(scene);
    let index = INSTANCE * 3 * OPTIONS_CONTACTS + contact;
    let rows: Vec<[f32; 4]> = scene.items(Phase::Evaluated, "contact_rows", index, stride);
    rows.iter().map(|r| vec([r[0], r[1], r[2]])).collect()
}

/// The list is exact but for k a and k a δ (two roundings) and friction's slopes: with |u|/|u_T| the cancellation
/// in u_T (5), a length (4) and a polynomial (5). Rows: T (n_h + 2), T − J, a row of R (3), w, a cross product
/// (2); or Rᵀe (3), w, the sum over bones, U; or the point (as the skin's), x − c and a cross product.
pub fn compact(scene: &Scene) -> Outcome {
    let set = &scene.avatar.skin;
    let phase = Phase::Evaluated;
    let all = distances(scene, phase, phase.slot());
    let candidates: Vec<Candidate> = all.iter().map(candidate).collect();
    let mut want = Vec::new();
    let (areas, colliders) = (&set.measure, &scene.colliders);
    let active = compact_twin::compact(&candidates, areas, colliders, OPTIONS_CONTACTS, &mut want);
    let rubbing = slid(scene, phase, phase.slot(), None);
    for [_, (contact, slip)] in &rubbing {
        want.extend(friction_twin::rows(contact, slip, smoothing()));
    }
    let got = listed(scene);
    if active == 0 || active > OPTIONS_CONTACTS || rubbing.is_empty() {
        return Err(format!(
            "{active} contacts: the scene must have some, and room for them"
        ));
    }
    let key = |c: &ContactRow| (c.vertex, c.carrier);
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
        let [_, (contact, slip)] = rubbing[(k - active) / 2];
        let y = slip.length();
        let cancelled = 1.0 + slip.displacement.length() / y;
        let size = DVec3::splat(2.0 * cancelled);
        out.vector(got.direction, want.direction, size, 16);
        out.number(got.force, want.force, contact.limit * cancelled, 16);
        let slope = 4.0 * contact.limit / y.min(smoothing());
        out.number(got.stiffness, want.stiffness, slope * cancelled, 16);
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
        if let Some(c) = contact.carrier {
            let carrier = &frames[c as usize];
            let point = contact_point(skinning, scene.joints(), &frames, t);
            let [translation, rotation] = carrier_levers(carrier, point, e);
            let last = got.len() - 2;
            out.vector(got[last], translation, abs_e, 1);
            let abs_p = abs_position(scene, phase, phase.slot(), set, v, rest[v]);
            let magnitude = abs_cross(abs_p + carrier.position.abs(), abs_e);
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
