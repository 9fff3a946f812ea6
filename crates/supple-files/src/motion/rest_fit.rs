//! The alignment of rest poses, from the poses of a clip.

use super::fit::{Rule, Seen, best_rotation, fit_rotations, snapped};
use super::ground::GroundMove;
use super::pose::BonePose;
use super::retarget::Retarget;
use glam::{DMat3, DVec3};
use supple::model::Frame;
use supple_bake::Part;

/// The trunk keeps the avatar's own posture where the clip's is on average within so many degrees of it: people's
/// backs differ, and a back bent farther is bent.
const POSTURE: f64 = 25.0;
/// A pelvis whose axes are so near to the body's, degrees, has the body's.
const PELVIS: f64 = 15.0;

impl Retarget {
    /// Aligns by `poses` of the motion, whose joints' places are known, where its own rest pose says nothing of a
    /// figure. In each the avatar's bones are turned until its joints lie as the motion's do, by W_j; what of that no
    /// pose explains is the alignment, A⁻¹ D_j = arg min Σ |C G_j X − W_j|². Bones that no joint follows (a head, toes, a
    /// hand without fingers) are on average as their parents are, and the trunk is on average upright. The size, if
    /// `resize`, is that of the first pose.
    pub(super) fn fit_rest(&mut self, poses: &[Vec<BonePose>], resize: bool) {
        if let Some(first) = poses.first().filter(|_| resize) {
            let known = |t: usize| first.get(self.source[t]?)?.position;
            let places: Vec<Option<DVec3>> = (0..self.skeleton.len()).map(known).collect();
            self.scale = self.relative_size(&places);
        }
        let above: Vec<Option<usize>> = (0..self.skeleton.len())
            .map(|t| self.driven_above(t))
            .collect();
        let none = vec![DMat3::ZERO; above.len()];
        let (mut by_places, mut by_parent, mut by_up) = (none.clone(), none.clone(), none);
        for pose in poses {
            let seen = |t: usize| Seen {
                place: self.place(pose, t),
                end: None,
                rule: Rule::Directions,
            };
            let seen: Vec<Seen> = (0..above.len()).map(seen).collect();
            let fitted = fit_rotations(&self.skeleton, &seen);
            let turned = |t: usize| {
                let turned = pose.get(self.source[t]?)?.rotation?;
                Some(self.world * DMat3::from_quat(turned))
            };
            let upright = self.root().map_or(self.standing(), |root| {
                heading(fitted[root] * self.standing().transpose(), self.up()) * self.standing()
            });
            for t in 0..above.len() {
                let Some(own) = turned(t) else { continue };
                by_places[t] += own.transpose() * fitted[t];
                by_up[t] += own.transpose() * upright;
                if let Some(parent) = above[t].and_then(turned) {
                    by_parent[t] += own.transpose() * parent;
                }
            }
        }
        for t in 0..above.len() {
            if self.source[t].is_none() {
                continue;
            }
            let placed = mean(by_places[t]).unwrap_or(self.rest[t]);
            let carried = above[t].and_then(|p| Some(mean(by_parent[t])? * self.rest[p]));
            let ends = !above.contains(&Some(t));
            let upright = mean(by_up[t]).filter(|up| within(POSTURE, *up, placed));
            self.rest[t] = match (self.parts[t].map(|p| p.part), carried, upright) {
                (Some(Part::Head | Part::Toes), Some(carried), _) => carried,
                (_, Some(carried), _) if ends => carried,
                (Some(Part::Spine | Part::Neck | Part::Collar), _, Some(upright)) => upright,
                (Some(Part::Hips), ..) if within(PELVIS, snapped(placed), placed) => {
                    snapped(placed)
                }
                _ => placed,
            };
        }
    }

    /// The nearest driven bone above `t`.
    fn driven_above(&self, t: usize) -> Option<usize> {
        let parent = |t: &usize| self.skeleton.parents[*t].map(|p| p as usize);
        std::iter::successors(parent(&t), parent).find(|&p| self.source[p].is_some())
    }
}

/// The part of a rotation about `up`.
fn heading(turn: DMat3, up: DVec3) -> DMat3 {
    let from = Frame {
        rotation: DMat3::IDENTITY,
        position: DVec3::ZERO,
    };
    let to = Frame {
        rotation: turn,
        ..from
    };
    GroundMove::between(&from, &to, up).apply(&from).rotation
}

/// The rotation nearest to a sum of rotations.
fn mean(sum: DMat3) -> Option<DMat3> {
    best_rotation(&[
        (DVec3::X, sum.x_axis),
        (DVec3::Y, sum.y_axis),
        (DVec3::Z, sum.z_axis),
    ])
}

/// Whether the angle between two rotations is at most so many degrees: tr(AᵀB) = 1 + 2 cos.
fn within(degrees: f64, a: DMat3, b: DMat3) -> bool {
    let trace = a.x_axis.dot(b.x_axis) + a.y_axis.dot(b.y_axis) + a.z_axis.dot(b.z_axis);
    0.5 * (trace - 1.0) >= degrees.to_radians().cos()
}
