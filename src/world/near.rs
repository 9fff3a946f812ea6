//! What is near an avatar: a cheap, sure answer from its bones alone.

use crate::collider::{Collider, Shape};
use crate::model::{Avatar, Frame, pose_features};
use crate::sim::Instance;
use glam::DVec3;

/// Spheres around the bones that hold the skin in every pose.
///
/// A posed vertex is a convex combination of its bones' rigid images of x̄ + Σ U φ, so it lies within the hull of balls
/// about their joints, of radius max |X − J| and what blend shapes, a host's offsets u and handles add:
///
/// ```text
/// |B_P| ≤ Σ_j |f_j| max_i (Σ_k |column_k,i|²)^½      max |u|      |Σ U φ| ≤ max_i Σ |U| · max |φ|
/// ```
#[derive(Clone, Debug)]
pub(super) struct SkinBounds {
    /// Of each bone; 0 where it moves no vertex.
    radius: Vec<f64>,
    /// For each group of nine pose features, the largest norm of their columns at a vertex, m.
    blend: Vec<f64>,
    /// max Σ |U|, of fine handles too.
    reach: f64,
}

impl SkinBounds {
    pub fn new(avatar: &Avatar) -> Self {
        let skin = &avatar.skin;
        let mut radius = vec![0.0f64; avatar.skeleton.len()];
        let mut reach = 0.0f64;
        for i in 0..skin.len() {
            for weight in skin.skinning.row(i).iter().filter(|w| w.weight != 0.0) {
                let bone = weight.bone as usize;
                let distance = skin.position[i].distance(avatar.skeleton.joints[bone]);
                radius[bone] = radius[bone].max(distance);
            }
            let coarse: f64 = skin.basis.row(i).iter().map(|u| u.value.abs()).sum();
            let fine = match avatar.fine.slots {
                0 => 0.0,
                _ => (avatar.fine.skin.row(i).iter())
                    .map(|(_, u)| f64::from(u.abs()))
                    .sum(),
            };
            reach = reach.max(coarse + fine);
        }
        let columns = &skin.pose_blend.columns;
        let norm = |group: usize, i: usize| {
            let column = |k: usize| columns[(9 * group + k) * skin.len() + i];
            let squares = (0..9).flat_map(column).map(|c| f64::from(c).powi(2));
            squares.sum::<f64>().sqrt()
        };
        let largest = |group| (0..skin.len()).map(|i| norm(group, i)).fold(0.0, f64::max);
        Self {
            radius,
            blend: (0..skin.pose_blend.features / 9).map(largest).collect(),
            reach,
        }
    }

    /// By how much the skin may leave the bones' own spheres, m.
    fn slack(&self, parents: &[Option<u32>], instance: &Instance) -> f64 {
        let state = &instance.state;
        let longest = state.handles.iter().map(|h| h.length_squared());
        let displaced = self.reach * longest.fold(0.0, f64::max).sqrt();
        let (mut blended, mut square) = (0.0, 0.0);
        if !self.blend.is_empty() {
            for (k, feature) in pose_features(parents, &state.frames).enumerate() {
                square += feature * feature;
                if k % 9 == 8 {
                    blended += square.sqrt() * self.blend.get(k / 9).copied().unwrap_or(0.0);
                    square = 0.0;
                }
            }
        }
        displaced + blended + instance.pose_offsets.longest()
    }

    /// The spheres of an instance as it is: centre and radius, m.
    fn spheres<'a>(
        &'a self,
        parents: &[Option<u32>],
        instance: &'a Instance,
    ) -> impl Iterator<Item = (DVec3, f64)> + use<'a> {
        let slack = self.slack(parents, instance);
        let moved = self.radius.iter().zip(&instance.state.frames);
        let skinned = moved.filter(|(radius, _)| **radius > 0.0);
        skinned.map(move |(radius, frame)| (frame.position, radius + slack))
    }

    /// Whether the skin may come within `margin` of a ball.
    pub fn meets(
        &self,
        parents: &[Option<u32>],
        instance: &Instance,
        (centre, radius): (DVec3, f64),
        margin: f64,
    ) -> bool {
        let touches = |(c, r): (DVec3, f64)| c.distance(centre) <= r + radius + margin;
        self.spheres(parents, instance).any(touches)
    }

    /// Lowest and highest corner of a box that holds the skin, m; low above high where there is none.
    pub fn corners(&self, parents: &[Option<u32>], instance: &Instance) -> [DVec3; 2] {
        let none = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        (self.spheres(parents, instance)).fold(none, |[low, high], (c, r)| {
            [low.min(c - DVec3::splat(r)), high.max(c + DVec3::splat(r))]
        })
    }
}

/// A ball around a collider where it stands; none where it is without bounds.
pub(super) fn ball(collider: &Collider, frame: &Frame) -> Option<(DVec3, f64)> {
    let radius = match &collider.shape {
        Shape::HalfSpace => return None,
        Shape::Sphere { radius } => *radius,
        Shape::Capsule {
            radius,
            half_length,
        } => radius + half_length,
        Shape::Cylinder {
            radius,
            half_length,
        } => radius.hypot(*half_length),
        Shape::Box { half_extents } => DVec3::from_array(*half_extents).length(),
        Shape::Mesh(mesh) => mesh.bounding_radius(),
    };
    Some((frame.position, radius + collider.margin))
}
