//! Bones derived from joints and skin weights: capsules from each joint to its children's.
//!
//! A bone's axes run from its joint to the joints of its children; the axis of a bone without children
//! runs to the tip of the skin that follows it. The radius is a share of the skin's cross-section:
//! of the median distance between the axis and the skin that follows the bone. An axis is cut to where its
//! capsule stays well inside the skin; a bone that the skin does not follow has none.

use super::sound_skin::SoundSkin;
use crate::math::TriangleTree;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};
use supple::internal::math::{Rows, par_map};
use supple::model::{Skeleton, SkinWeight, Surface};

/// A capsule within a bone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoneAxis {
    /// Whose it is.
    pub bone: u32,
    /// From here to there, m.
    pub ends: [DVec3; 2],
    /// m.
    pub radius: f64,
}

/// Radius of a bone relative to the cross-section of the skin around it.
const CORE: f64 = 0.45;

/// The surface of a bone stays away from the skin: its radius is at most this part of the way there.
const MOST_CORE: f64 = 0.7;

/// Skin follows a bone that has at least this weight.
const FOLLOWS: f64 = 0.5;

/// Places along an axis that are looked at.
const STATIONS: usize = 17;

/// Sectors of a capsule's surface, and rings of each of its ends.
const SECTORS: usize = 12;
const CAP_RINGS: usize = 3;

impl BoneAxis {
    /// The place on the axis that is closest to `p`.
    pub fn closest(&self, p: DVec3) -> DVec3 {
        let [a, b] = self.ends;
        let along = (p - a).dot(b - a) / (b - a).length_squared().max(f64::MIN_POSITIVE);
        a + along.clamp(0.0, 1.0) * (b - a)
    }

    /// Distance of `p` from the capsule, negative inside.
    pub fn distance(&self, p: DVec3) -> f64 {
        self.closest(p).distance(p) - self.radius
    }

    /// The capsule's surface, added to `surface`.
    pub fn add_surface(&self, surface: &mut Surface) {
        let [a, b] = self.ends;
        let along = (b - a).try_normalize().unwrap_or(DVec3::Z);
        let (side, up) = along.any_orthonormal_pair();
        let first = surface.positions.len() as u32;
        surface.positions.push(a - self.radius * along);
        // From pole to pole; (side, up, along) is right-handed.
        for ring in 1..=2 * CAP_RINGS {
            let (centre, step) = if ring <= CAP_RINGS {
                (a, ring)
            } else {
                (b, ring - 1)
            };
            let (sine, cosine) = (FRAC_PI_2 * step as f64 / CAP_RINGS as f64).sin_cos();
            for k in 0..SECTORS {
                let (y, x) = (TAU * k as f64 / SECTORS as f64).sin_cos();
                let outward = sine * (x * side + y * up) - cosine * along;
                surface.positions.push(centre + self.radius * outward);
            }
        }
        surface.positions.push(b + self.radius * along);
        let last = surface.positions.len() as u32 - 1;
        let vertex =
            |ring: usize, k: usize| first + 1 + (SECTORS * (ring - 1) + k % SECTORS) as u32;
        for k in 0..SECTORS {
            surface
                .triangles
                .push([first, vertex(1, k + 1), vertex(1, k)]);
            for ring in 1..2 * CAP_RINGS {
                let [p, q, r, s] = [
                    vertex(ring, k),
                    vertex(ring, k + 1),
                    vertex(ring + 1, k + 1),
                    vertex(ring + 1, k),
                ];
                surface.triangles.extend([[p, q, r], [p, r, s]]);
            }
            let top = 2 * CAP_RINGS;
            surface
                .triangles
                .push([vertex(top, k), vertex(top, k + 1), last]);
        }
    }
}

/// The surface of each bone that `axes` name; empty for the others.
pub fn axis_surfaces(axes: &[BoneAxis], bones: usize) -> Vec<Surface> {
    let mut surfaces = vec![Surface::default(); bones];
    for axis in axes {
        axis.add_surface(&mut surfaces[axis.bone as usize]);
    }
    surfaces
}

/// The bone of largest weight of each vertex, the first of equals.
pub(crate) fn leading_bones(skinning: &Rows<SkinWeight>) -> Vec<Option<u32>> {
    let leading = |row: &[SkinWeight]| {
        let largest = row
            .iter()
            .max_by(|a, b| a.weight.total_cmp(&b.weight).then(b.bone.cmp(&a.bone)));
        largest.filter(|w| w.weight > 0.0).map(|w| w.bone)
    };
    skinning.iter().map(leading).collect()
}

/// The axes of every bone that the skin follows, bone after bone.
pub fn bone_axes(
    skeleton: &Skeleton,
    skin: &SoundSkin,
    skinning: &Rows<SkinWeight>,
) -> Vec<BoneAxis> {
    let mut followers: Vec<Vec<DVec3>> = vec![Vec::new(); skeleton.len()];
    let mut leaders: Vec<Vec<DVec3>> = vec![Vec::new(); skeleton.len()];
    let places = skin.surface.positions.iter();
    for ((row, leading), &place) in skinning.iter().zip(leading_bones(skinning)).zip(places) {
        if let Some(bone) = leading {
            leaders[bone as usize].push(place);
        }
        for w in row.iter().filter(|w| w.weight >= FOLLOWS) {
            followers[w.bone as usize].push(place);
        }
    }
    let size = extent(&skin.surface);
    let wanted: Vec<BoneAxis> = (0..skeleton.len())
        .flat_map(|j| {
            let around = if followers[j].is_empty() {
                &leaders[j]
            } else {
                &followers[j]
            };
            wanted_axes(skeleton, j, around, size)
        })
        .collect();
    let triangles = TriangleTree::of(&skin.surface);
    let fitted = par_map(wanted.len(), |i| fit(wanted[i], &triangles));
    fitted.into_iter().flatten().collect()
}

/// Largest extent of a surface, m.
pub(crate) fn extent(surface: &Surface) -> f64 {
    let positions = || surface.positions.iter().copied();
    let low = positions().fold(DVec3::INFINITY, DVec3::min);
    let high = positions().fold(DVec3::NEG_INFINITY, DVec3::max);
    (high - low).max_element()
}

/// The axes of bone `j` as joints and cross-sections want them; `around` is the skin that follows it.
fn wanted_axes(skeleton: &Skeleton, j: usize, around: &[DVec3], size: f64) -> Vec<BoneAxis> {
    if around.is_empty() {
        return Vec::new();
    }
    let joint = skeleton.joints[j];
    let is_child = |parent: &Option<u32>| *parent == Some(j as u32);
    let mut ends: Vec<DVec3> = (skeleton.parents.iter().zip(&skeleton.joints))
        .filter(|(parent, end)| is_child(parent) && end.distance(joint) > 1e-3 * size)
        .map(|(_, end)| *end)
        .collect();
    if ends.is_empty() {
        ends.push(tip(joint, around));
    } else if skeleton.parents[j].is_none() {
        // A root may reach back from its joint too: a wrist into the forearm.
        let ahead = |p: &DVec3| ends.iter().any(|end| (*p - joint).dot(*end - joint) > 0.0);
        let behind: Vec<DVec3> = around.iter().copied().filter(|p| !ahead(p)).collect();
        if !behind.is_empty() {
            ends.push(tip(joint, &behind));
        }
    }
    let mut axes: Vec<BoneAxis> = (ends.into_iter())
        .map(|end| BoneAxis {
            bone: j as u32,
            ends: [joint, end],
            radius: 0.0,
        })
        .collect();
    // Every vertex belongs to the closest axis; what lies beyond an axis' ends says nothing of its girth.
    let mut distances: Vec<Vec<f64>> = vec![Vec::new(); axes.len()];
    let mut all: Vec<f64> = Vec::new();
    for &p in around {
        let from = |axis: &BoneAxis| axis.closest(p).distance(p);
        let nearest = (axes.iter().map(from).enumerate()).min_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((i, distance)) = nearest {
            all.push(distance);
            if axes[i].ends.iter().all(|end| axes[i].closest(p) != *end) {
                distances[i].push(distance);
            }
        }
    }
    for (axis, beside) in axes.iter_mut().zip(distances) {
        let beside = if beside.len() < 3 { &all } else { &beside };
        axis.radius = CORE * median(beside);
    }
    axes
}

/// Where the skin `around` a joint that has no child ends: in the direction of its middle, as far as
/// it reaches.
fn tip(joint: DVec3, around: &[DVec3]) -> DVec3 {
    let middle = around.iter().sum::<DVec3>() / around.len() as f64;
    let direction = (middle - joint).normalize_or_zero();
    let reach = around.iter().map(|p| (*p - joint).dot(direction));
    joint + direction * reach.fold(0.0, f64::max)
}

pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

/// Cuts an axis to the longest run of places where its capsule stays inside, and thins it where
/// that is less than half of what lies inside.
fn fit(axis: BoneAxis, skin: &TriangleTree) -> Option<BoneAxis> {
    let station = |i: usize| axis.ends[0].lerp(axis.ends[1], i as f64 / (STATIONS - 1) as f64);
    let room: Vec<f64> = (0..STATIONS)
        .map(|i| {
            let place = station(i);
            if skin.winding_number(place) < 1 {
                return 0.0;
            }
            MOST_CORE * skin.distance(place)
        })
        .collect();
    let inside = room.iter().filter(|r| **r > 0.0).count();
    let mut radius = axis.radius;
    for _ in 0..12 {
        let (first, last) = longest_run(&room, radius);
        let length = last - first;
        if radius > 0.0 && length > 0 && 2 * length >= inside {
            return Some(BoneAxis {
                ends: [station(first), station(last - 1)],
                radius,
                ..axis
            });
        }
        radius *= 0.8;
    }
    None
}

/// The longest run `first..last` of `room` that holds at least `radius`.
fn longest_run(room: &[f64], radius: f64) -> (usize, usize) {
    let mut best = (0, 0);
    let mut first = 0;
    for i in 0..=room.len() {
        if i == room.len() || room[i] < radius {
            if i - first > best.1 - best.0 {
                best = (first, i);
            }
            first = i + 1;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_capsule_is_closed_and_has_its_volume() {
        for ends in [[DVec3::ZERO, DVec3::new(0.1, 0.02, -0.03)], [DVec3::Y; 2]] {
            let axis = BoneAxis {
                bone: 0,
                ends,
                radius: 0.02,
            };
            let surface = &axis_surfaces(&[axis], 2)[0];
            assert!(surface.is_closed());
            let length = ends[0].distance(ends[1]);
            let expected = PI * 0.02f64.powi(2) * length + 4.0 / 3.0 * PI * 0.02f64.powi(3);
            let ratio = surface.volume() / expected;
            assert!((0.85..1.0).contains(&ratio), "{ratio}");
            for p in &surface.positions {
                assert!(axis.distance(*p).abs() < 1e-12);
            }
        }
    }
}
