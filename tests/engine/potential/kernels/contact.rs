//! Kernel contact: distance and normal of every vertex at every collider.

use super::INSTANCE;
use super::bound::{Comparison, LENGTH, Outcome, QUOTIENT, abs};
use super::points::{abs_position, skin_roundings};
use super::scene::{OPTIONS_COLLIDERS, Phase, Scene, vec};
use supple::collider::Collider;
use supple::glam::{DMat3, DVec3};
use supple::internal::cpu::contact as contact_twin;
use supple::internal::cpu::contact::{Candidate, contact_point, may_touch};
use supple::internal::cpu::displacement::unposed_displacement;
use supple::model::{Frame, PointSet};

/// (n, δ) of every vertex at every collider of `slot`, vertex by vertex.
pub fn distances(scene: &Scene, phase: Phase, slot: usize) -> Vec<[f32; 4]> {
    let vertices = scene.avatar.skin.len();
    let mut all = scene.items(phase, "distances", slot, vertices * OPTIONS_COLLIDERS);
    all.truncate(vertices * scene.colliders.len());
    all
}

/// Whether kernel `select` marked a δ: no distance is so small.
pub fn is_left_out(depth: f32) -> bool {
    depth < -0.5e38
}

/// Of a shape's own: two lengths, one in the other, and two sums. A mesh's samples are off by less.
const SHAPE: usize = 2 * LENGTH + 2;

/// d of vertex `i`: it is 1-Lipschitz, so that its error is that of the point in the collider's frame (as the skin's, p − c
/// and a row of R: 4, and of R_c R and R_c p + c: 4 more) and of the shape.
pub fn distance_roundings(set: &PointSet, i: usize) -> usize {
    skin_roundings(set, i) + 4 + 4 + SHAPE
}

/// d as [`distance_roundings`] has it. n turns by the curvature ∇²d times the same, is a quotient, and is rotated back (3).
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
                let place = collider.world_frame(&frames);
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
                let roundings = distance_roundings(set, i);
                if !is_left_out(depth) {
                    out.number(f64::from(depth).max(0.0), want.depth, magnitude, roundings);
                }
                let curvature = collider.curvature(&place, p).to_cols_array();
                let curvature = curvature.iter().map(|c| c * c).sum::<f64>().sqrt();
                let magnitude = DVec3::splat(2.0 + magnitude * curvature);
                out.vector(
                    vec([x, y, z]),
                    want.normal,
                    magnitude,
                    roundings + QUOTIENT + 3,
                );
            }
        }
    }
    out.finish("δ and n")
}

/// Rotation and position of a collider's place with all signs plus.
pub fn abs_place(collider: &Collider, frames: &[Frame]) -> (DMat3, DVec3) {
    let (r, p) = (abs(collider.frame.rotation), collider.frame.position.abs());
    match collider.body {
        None => (r, p),
        Some(c) => {
            let body = &frames[c as usize];
            let abs_body = abs(body.rotation);
            (abs_body * r, abs_body * p + body.position.abs())
        }
    }
}

pub fn candidate(&[x, y, z, depth]: &[f32; 4]) -> Candidate {
    Candidate {
        depth: f64::from(depth),
        normal: vec([x, y, z]),
    }
}
