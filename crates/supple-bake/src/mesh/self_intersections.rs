//! How often a skin cuts itself.

use super::skin_points::segment_meets;
use glam::DVec3;
use supple::internal::math::par_map;
use supple::model::Surface;

/// Pairs of triangles that cut each other and share no vertex. Boxes are swept along the longest
/// axis; two triangles cut each other where an edge of one meets the other. Touching counts; lying in one
/// plane does not.
pub(super) fn self_intersections(skin: &Surface) -> usize {
    let boxes: Vec<[DVec3; 2]> = (0..skin.triangles.len())
        .map(|t| {
            let [a, b, c] = skin.corners(t);
            [a.min(b).min(c), a.max(b).max(c)]
        })
        .collect();
    let low = boxes.iter().map(|b| b[0]).fold(DVec3::INFINITY, DVec3::min);
    let high = boxes
        .iter()
        .map(|b| b[1])
        .fold(DVec3::NEG_INFINITY, DVec3::max);
    let axis = (high - low).max_position();
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by(|&s, &t| {
        boxes[s][0][axis]
            .total_cmp(&boxes[t][0][axis])
            .then(s.cmp(&t))
    });
    let cuts = par_map(order.len(), |i| {
        let s = order[i];
        let later = order[i + 1..].iter();
        later
            .take_while(|&&t| boxes[t][0][axis] <= boxes[s][1][axis])
            .filter(|&&t| {
                boxes[s][0].cmple(boxes[t][1]).all() && boxes[t][0].cmple(boxes[s][1]).all()
            })
            .filter(|&&t| {
                let other = skin.triangles[t];
                !skin.triangles[s].iter().any(|v| other.contains(v))
            })
            .filter(|&&t| cut(&skin.corners(s), &skin.corners(t)))
            .count()
    });
    cuts.into_iter().sum()
}

fn cut(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    let meets = |x: &[DVec3; 3], y| (0..3).any(|i| segment_meets(x[i], x[(i + 1) % 3], y));
    meets(a, b) || meets(b, a)
}
