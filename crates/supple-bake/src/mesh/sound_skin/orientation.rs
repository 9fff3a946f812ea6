//! All triangles of a part look the same way, and that way is outward.

use super::edges::edges;
use crate::math::winding_number;
use glam::DVec3;
use std::collections::BTreeMap;
use supple::model::Surface;

/// A part that encloses less than this, relative to its area to the power of 3/2, is flat.
const FLAT: f64 = 1e-6;

/// Whether `b` is a rotation of `a`.
pub(super) fn same_way(a: [u32; 3], b: [u32; 3]) -> bool {
    (0..3).any(|r| (0..3).all(|i| a[i] == b[(i + r) % 3]))
}

/// Makes neighbours across edges of two triangles look the same way: in each patch of them the
/// smaller part is turned.
pub(super) fn make_consistent(surface: &mut Surface) {
    let mut neighbours: Vec<Vec<(u32, bool)>> = vec![Vec::new(); surface.triangles.len()];
    for sides in edges(&surface.triangles).values() {
        if let &[(s, along_s), (t, along_t)] = sides.as_slice() {
            neighbours[s as usize].push((t, along_s == along_t));
            neighbours[t as usize].push((s, along_s == along_t));
        }
    }
    let mut turned: Vec<Option<bool>> = vec![None; surface.triangles.len()];
    for first in 0..turned.len() {
        if turned[first].is_some() {
            continue;
        }
        turned[first] = Some(false);
        let mut patch = vec![first];
        let mut next = 0;
        while let Some(&t) = patch.get(next) {
            next += 1;
            for &(s, opposed) in &neighbours[t] {
                if turned[s as usize].is_none() {
                    turned[s as usize] = turned[t].map(|turn| turn != opposed);
                    patch.push(s as usize);
                }
            }
        }
        let minority = patch.iter().filter(|&&t| turned[t] == Some(true)).count();
        let other_way = 2 * minority > patch.len();
        for &t in &patch {
            if (turned[t] == Some(true)) != other_way {
                surface.triangles[t].swap(1, 2);
            }
        }
    }
}

/// Turns every part that encloses a negative volume, unless it lies inside another part: that is a
/// cavity.
pub(super) fn turn_outward(surface: &mut Surface, part: &[u32]) {
    let mut of_part: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for (t, triangle) in surface.triangles.iter().enumerate() {
        // The first corner of a cap's triangle is a vertex of the skin.
        of_part
            .entry(part[triangle[0] as usize])
            .or_default()
            .push(t as u32);
    }
    let volume = |surface: &Surface, triangles: &[u32]| -> f64 {
        // From a point of the part, so that far-away parts lose no digits.
        let origin = surface.corners(triangles[0] as usize)[0];
        let spanned = triangles.iter().map(|&t| {
            let [a, b, c] = surface.corners(t as usize).map(|p| p - origin);
            a.dot(b.cross(c)) / 6.0
        });
        spanned.sum()
    };
    let mut order: Vec<(f64, Vec<u32>)> = (of_part.into_values())
        .map(|triangles| (volume(surface, &triangles), triangles))
        .collect();
    // The largest first: it is no cavity.
    order.sort_by(|a, b| b.0.abs().total_cmp(&a.0.abs()));
    let mut done: Vec<u32> = Vec::new();
    for (volume, triangles) in order {
        let areas = triangles
            .iter()
            .map(|&t| surface.area_vector(t as usize).length());
        if volume < -FLAT * areas.sum::<f64>().powf(1.5) {
            let place = surface.corners(triangles[0] as usize).iter().sum::<DVec3>() / 3.0;
            let around = done.iter().map(|&t| surface.corners(t as usize));
            if winding_number(place, around) < 0.5 {
                (triangles.iter()).for_each(|&t| surface.triangles[t as usize].swap(1, 2));
            }
        }
        done.extend(triangles);
    }
}
