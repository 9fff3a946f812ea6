//! How deep the tissue lies under the skin: by bone, and where it is much thinner than around.

use crate::body::Body;
use crate::mesh::{closed, extent, leading_bones, median, neighbours};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::fmt;
use supple::internal::math::Rows;

/// What lies around a place, relative to the skin's largest extent: four fingers' width of a person.
const AROUND: f64 = 0.04;

/// A place is thin where it is less deep than this part of what lies around, and that is this part of what is deep.
const THIN: f64 = 0.4;
const WORTH_TELLING: f64 = 0.5;

/// A place where the tissue is much thinner than around it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ThinPlace {
    /// The bone that leads the skin there.
    pub bone: String,
    /// Its thinnest vertex, in the reference shape, m.
    pub position: [f64; 3],
    /// Depth there, m.
    pub depth: f64,
    /// Depth of what lies around, m.
    pub around: f64,
    /// Area of the thin skin, m².
    pub area: f64,
}

impl fmt::Display for ThinPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.position;
        write!(
            f,
            "{:.1} mm at ({x:.3}, {y:.3}, {z:.3}) on {} amid {:.1} mm, over {:.1} cm²: it will hardly move; a recipe's \
             painted_thickness or a lattice gives it depth",
            1e3 * self.depth,
            self.bone,
            1e3 * self.around,
            1e4 * self.area
        )
    }
}

/// Least, median and greatest of the `depth` under the skin that follows each bone, m; 0 where none does.
pub(crate) fn depth_per_bone(body: &Body, depth: &[f64]) -> Vec<[f64; 3]> {
    let mut of_bone = vec![Vec::new(); body.skeleton.len()];
    for (leading, depth) in leading_bones(&body.skinning).into_iter().zip(depth) {
        if let Some(bone) = leading.filter(|_| depth.is_finite()) {
            of_bone[bone as usize].push(*depth);
        }
    }
    let spread = |values: &Vec<f64>| {
        let least = values.iter().copied().reduce(f64::min).unwrap_or(0.0);
        let greatest = values.iter().copied().fold(0.0, f64::max);
        [least, median(values), greatest]
    };
    of_bone.iter().map(spread).collect()
}

/// The thin places of a layer, the largest first; `deep` is what counts as deep.
pub(crate) fn thin_places(body: &Body, depth: &[f64], deep: f64) -> Vec<ThinPlace> {
    if depth.is_empty() || !depth.iter().all(|d| d.is_finite()) {
        return Vec::new();
    }
    let skin = &body.skin;
    let around = neighbours(skin);
    let usual = closed(skin, &around, AROUND * extent(skin), depth);
    let is_thin = |v: usize| depth[v] < THIN * usual[v] && usual[v] > WORTH_TELLING * deep;
    let areas = skin.vertex_areas();
    let leading = leading_bones(&body.skinning);
    let place = |part: Vec<u32>| {
        let thinnest = part.iter().copied().reduce(|best, v| {
            let thinner = depth[v as usize] < depth[best as usize];
            if thinner { v } else { best }
        });
        let v = thinnest.unwrap_or_default() as usize;
        let bone = leading[v].map_or(String::new(), |b| body.skeleton.names[b as usize].clone());
        ThinPlace {
            bone,
            position: DVec3::to_array(&skin.positions[v]),
            depth: depth[v],
            around: usual[v],
            area: part.iter().map(|&v| areas[v as usize]).sum(),
        }
    };
    let mut places: Vec<ThinPlace> = parts(&around, is_thin).into_iter().map(place).collect();
    places.sort_by(|a, b| b.area.total_cmp(&a.area));
    places
}

/// The vertices of each connected part where `wanted` holds.
fn parts(around: &Rows<u32>, wanted: impl Fn(usize) -> bool) -> Vec<Vec<u32>> {
    let mut left: Vec<bool> = (0..around.len()).map(wanted).collect();
    let mut parts = Vec::new();
    for first in 0..left.len() {
        if !std::mem::take(&mut left[first]) {
            continue;
        }
        let mut part = vec![first as u32];
        let mut next = 0;
        while let Some(&v) = part.get(next) {
            next += 1;
            for &u in around.row(v as usize) {
                if std::mem::take(&mut left[u as usize]) {
                    part.push(u);
                }
            }
        }
        parts.push(part);
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limb;

    #[test]
    fn a_thin_place_is_told_and_what_is_thin_all_over_is_not() {
        let limb = Limb {
            stations: 60,
            layers: 1,
            sectors: 60,
            ..Limb::S
        };
        let body = limb.body().unwrap();
        let middle = DVec3::new(0.5 * limb.length, 0.0, limb.outer_radius);
        let near = |p: &DVec3| p.distance(middle) < 0.006;
        let depth = |p: &DVec3| if near(p) { 0.003 } else { 0.025 };
        let depth: Vec<f64> = body.skin.positions.iter().map(depth).collect();
        let places = thin_places(&body, &depth, 0.025);
        let [place] = &places[..] else {
            panic!("{places:?}");
        };
        assert_eq!(place.bone, body.skeleton.names[0]);
        assert!((place.depth, place.around) == (0.003, 0.025));
        assert!(DVec3::from(place.position).distance(middle) < 0.006);
        // A disc of 6 mm, give or take the triangles at its rim.
        assert!((0.6e-4..1.7e-4).contains(&place.area), "{place}");
        assert!(place.to_string().contains("3.0 mm"), "{place}");
        let [least, median, greatest] = depth_per_bone(&body, &depth)[0];
        assert_eq!((least, median, greatest), (0.003, 0.025, 0.025));
        assert_eq!(thin_places(&body, &vec![0.003; depth.len()], 0.025), []);
        assert_eq!(
            thin_places(&body, &vec![f64::INFINITY; depth.len()], 0.025),
            []
        );
    }
}
