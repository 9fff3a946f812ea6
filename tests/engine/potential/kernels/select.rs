//! Kernel select: the deepest pairs at a step's start, as many as there is room for.

use super::INSTANCE;
use super::bound::{Outcome, U};
use super::contact::{abs_place, distance_roundings, distances, is_left_out};
use super::points::abs_position;
use super::scene::{OPTIONS_CONTACTS, Phase, Scene};
use supple::internal::cpu::contact::{contact_point, may_touch};
use supple::internal::cpu::displacement::unposed_displacement;
use supple::internal::cpu::select::keep_deepest;

/// Marks leave no trace of the δ that they replace, so that it is computed again; near the end of the room a pair may be
/// kept or not by the error of its δ (roundings as kernel `contact`'s). How many are kept is exact: no two are equal.
pub fn select(scene: &Scene) -> Outcome {
    let (set, phase) = (&scene.avatar.skin, Phase::Evaluated);
    let rest = scene.rest(phase, "skin_unposed", set);
    let (frames, phi) = (
        scene.frames(phase, INSTANCE),
        scene.displaced(phase, INSTANCE),
    );
    let mut depths = Vec::new();
    let mut errors = Vec::new();
    for i in 0..set.len() {
        let (skinning, basis) = (set.skinning.row(i), set.basis.row(i));
        let t = rest[i] + unposed_displacement(basis, &phi);
        let p = contact_point(skinning, scene.joints(), &frames, t);
        let abs_p = abs_position(scene, phase, INSTANCE, set, i, rest[i]);
        for collider in &scene.colliders {
            let place = collider.world_frame(&frames);
            let touches = set.measure[i] > 0.0 && may_touch(skinning, collider);
            let depth = collider.margin - collider.signed_distance(&place, p).distance;
            depths.push(touches.then_some(depth as f32));
            let sizes = collider.shape.parameters().iter().sum::<f32>();
            let (to_local, abs_place) = abs_place(collider, &frames);
            let local = to_local.transpose() * (abs_p + abs_place);
            let magnitude = local.element_sum() + f64::from(sizes) + collider.margin;
            errors.push(U * magnitude * distance_roundings(set, i) as f64);
        }
    }
    let kept = keep_deepest(&depths, OPTIONS_CONTACTS);
    let end = (depths.iter().zip(&kept).filter(|(_, kept)| !**kept))
        .filter_map(|(depth, _)| *depth)
        .fold(f32::NEG_INFINITY, f32::max);
    let got = distances(scene, phase, INSTANCE);
    let later = distances(scene, phase, phase.slot());
    let mut count = 0;
    for (k, depth) in depths.iter().enumerate() {
        let left_out = is_left_out(got[k][3]);
        if left_out != is_left_out(later[k][3]) {
            return Err(format!(
                "pair {k} is left out at the start or later, not both"
            ));
        }
        let Some(depth) = depth else {
            continue;
        };
        count += usize::from(!left_out);
        let near = f64::from((depth - end).abs()) <= 2.0 * errors[k];
        if left_out == kept[k] && !near {
            return Err(format!("pair {k} at {depth} m, the room ends at {end} m"));
        }
        let touching = got[k][3] < -1.5e38;
        if left_out && touching != (*depth > 0.0) && f64::from(depth.abs()) > errors[k] {
            return Err(format!(
                "pair {k} at {depth} m is marked as touching: {touching}"
            ));
        }
    }
    let wanted = kept
        .iter()
        .zip(&depths)
        .filter(|(kept, depth)| **kept && depth.is_some());
    let wanted = wanted.count();
    if wanted != OPTIONS_CONTACTS || count != wanted {
        return Err(format!(
            "{count} pairs are kept of {wanted}; the scene must have more than the room"
        ));
    }
    Ok(())
}
