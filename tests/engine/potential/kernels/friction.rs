//! Kernel friction: the contacts of a step's start that have friction, and their slip.

use super::INSTANCE;
use super::bound::{Comparison, LENGTH, Outcome, QUOTIENT, abs};
use super::contact::candidate;
use super::points::{abs_position, minus_joints, skin_roundings};
use super::scene::{
    OPTIONS_COLLIDERS, OPTIONS_CONTACTS, Phase, SLIP_SPEED, Scene, TIME_STEP, mat, vec,
};
use supple::collider::Collider;
use supple::glam::DVec3;
use supple::internal::cpu::contact::{Candidate, contact_point};
use supple::internal::cpu::displacement::{FrameMotion, displacement, unposed_displacement};
use supple::internal::cpu::friction::{Lagged, Slip};
use supple::internal::cpu::{compact as compact_twin, friction as friction_twin};
use supple::internal::gpu::shared;
use supple::model::Frame;

/// ε, m.
pub fn smoothing() -> f64 {
    f64::from((SLIP_SPEED * TIME_STEP) as f32)
}

/// (Place at tⁿ, its motion over the step) of the frames that the colliders are fixed to, as the device has them.
fn grounds(scene: &Scene) -> (Vec<Frame>, Vec<FrameMotion>) {
    let phase = Phase::Evaluated;
    let frames = scene.frames(phase, INSTANCE);
    let all: Vec<shared::Collider> =
        scene.items(phase, "previous_colliders", INSTANCE, OPTIONS_COLLIDERS);
    let ground = |(collider, c): (&Collider, &shared::Collider)| {
        let place = match collider.body {
            None => Frame {
                rotation: mat(c.rotation),
                position: vec(c.position),
            },
            Some(body) => frames[body as usize],
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
        body: c.body.checked_sub(1),
        anchor: vec(c.anchor),
        normal: vec(c.normal),
        limit: f64::from(c.limit),
    }
}

/// A row of a matrix times a vector: a product and two sums.
const ROW: usize = 3;

/// The lagged list, exact but for
/// - μ λ = μ (k a δ |∇d|): a length and four products;
/// - a = Rᵀ (p − c): the point (as the skin's), a difference and a row;
/// - n = Rᵀ (∇d/|∇d|), where the collider's motion is given R n + ΔR n of that: a length, a quotient and a
///   row, then another and a sum;
/// - u at qⁿ = −(ΔR a + Δc): a row and a sum more than a.
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
        |v, c| scene.contact_stiffness(v, c),
        colliders,
        &places,
        point,
        &mut want,
    );
    let got = lagged(scene);
    let key = |l: &Lagged| (l.vertex, l.collider, l.body);
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
        let limit = f64::from(got.limit);
        out.number(limit, want.limit, want.limit, LENGTH + 4);
        let abs_rotation = abs(places[k].rotation);
        let abs_p = abs_position(scene, phase, INSTANCE, set, v, rest[v]);
        let abs_anchor = abs_rotation.transpose() * (abs_p + places[k].position.abs());
        let roundings = skin_roundings(set, v) + 1 + ROW;
        out.vector(vec(got.anchor), want.anchor, abs_anchor, roundings);
        let abs_normal = candidates[v * colliders.len() + k].normal.normalize().abs();
        let abs_normal = abs_rotation.transpose() * abs_normal;
        let unit = LENGTH + QUOTIENT + ROW;
        if want.body.is_some() {
            out.vector(vec(got.normal), want.normal, abs_normal, unit);
            continue;
        }
        let motion = &motions[k];
        let abs_change = abs(motion.rotation_change);
        let normal = motion.rotation * want.normal;
        let abs_normal = (abs_rotation + abs_change) * abs_normal;
        out.vector(vec(got.normal), normal, abs_normal, unit + ROW + 1);
        let magnitude = abs_change * abs_anchor + motion.translation_change.abs();
        let start = -friction_twin::carried(want, motion);
        out.vector(vec(got.start), start, magnitude, roundings + ROW + 1);
    }
    slips_agree(scene, &got, &mut out)?;
    out.finish("friction")
}

fn slips(scene: &Scene, phase: Phase, slot: usize) -> Vec<DVec3> {
    let all: Vec<[f32; 4]> = scene.items(phase, "slips", slot, OPTIONS_CONTACTS);
    all.iter().map(|s| vec([s[0], s[1], s[2]])).collect()
}

/// u: as the displacement (basis + skinning + 8), and the difference from the body's ΔR a + Δc, whose own
/// path is shorter.
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
            if let Some(c) = contact.body {
                want -= friction_twin::carried(&contact, &motions[c as usize]);
                let anchor = Lagged {
                    anchor: contact.anchor.abs(),
                    ..contact
                };
                magnitude += friction_twin::carried(&anchor, &abs_motions[c as usize]);
            }
            out.vector(slip, want, magnitude, basis.len() + skinning.len() + 9);
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
        let normal = |frames: &[Frame]| match contact.body {
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
