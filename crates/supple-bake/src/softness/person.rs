//! Where the soft parts of a person are, told by the names and places of the bones.
//!
//! Heights are between the hips (0) and the neck (1), the front is left × up. A region's share is what the skin weights of its
//! bones and windows with smooth edges in these coordinates leave of a point.

use crate::body::{Body, BodyPart, Part, Side, skeleton_parts};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use supple::model::SkinWeight;

/// A soft part of a person, both sides together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BodyRegion {
    /// Front of the trunk above the waist.
    Breast,
    /// Front of the trunk below that.
    Belly,
    /// Back of the pelvis and of the thighs' upper end.
    Buttock,
    /// From the hip to the knee.
    Thigh,
    /// From the knee to the ankle.
    Calf,
}

impl BodyRegion {
    /// All of them.
    pub const ALL: [Self; 5] = [
        Self::Breast,
        Self::Belly,
        Self::Buttock,
        Self::Thigh,
        Self::Calf,
    ];

    /// Its name in recipes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Breast => "breast",
            Self::Belly => "belly",
            Self::Buttock => "buttock",
            Self::Thigh => "thigh",
            Self::Calf => "calf",
        }
    }

    /// Whether what is deep in it is muscle.
    pub(crate) fn has_muscle(self) -> bool {
        matches!(self, Self::Thigh | Self::Calf)
    }
}

/// Where windows between heights begin and end.
const BREAST: [f64; 2] = [0.50, 0.88];
const BELLY: [f64; 2] = [0.02, 0.50];
const BUTTOCK: [f64; 2] = [-0.24, 0.22];
/// Width of their edges, relative to the height between hips and neck.
const EDGE: f64 = 0.06;

/// A person's frame.
#[derive(Clone, Debug)]
pub(crate) struct Person {
    /// What each bone belongs to.
    limb: Vec<Limb>,
    hips: DVec3,
    /// Towards the neck and to the front, 1/m: lengths in units of the height between hips and neck.
    up: DVec3,
    front: DVec3,
    /// Between front and back of the trunk.
    middle: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Limb {
    Trunk,
    Thigh,
    Calf,
    Other,
}

impl Person {
    /// The person that `body` is, where its bones' names tell one: two thighs, a calf, and a neck, a head or two arms.
    pub fn of(body: &Body) -> Option<Self> {
        let skeleton = &body.skeleton;
        let parts = skeleton_parts(skeleton);
        let places = |part: Part, side: Option<Side>| {
            let own = parts.iter().zip(&skeleton.joints);
            let own = own.filter(move |(p, _)| **p == Some(BodyPart { side, part }));
            own.map(|(_, joint)| *joint)
        };
        let first = |part, side| places(part, side).next();
        let (left, right) = (Some(Side::Left), Some(Side::Right));
        let thighs = [first(Part::UpperLeg, left)?, first(Part::UpperLeg, right)?];
        first(Part::LowerLeg, left)?;
        let arms = first(Part::UpperArm, left).zip(first(Part::UpperArm, right));
        let neck = (first(Part::Neck, None))
            .or(first(Part::Head, None))
            .or(arms.map(|(a, b)| 0.5 * (a + b)))?;
        let hips = 0.5 * (thighs[0] + thighs[1]);
        let height = (neck - hips).length();
        let up = (neck - hips).try_normalize()?;
        let aside = thighs[0] - thighs[1];
        let front = aside.cross(up).try_normalize()?;
        let mut limb: Vec<Limb> = Vec::with_capacity(parts.len());
        for (bone, part) in parts.iter().enumerate() {
            let parent = skeleton.parents[bone].map(|p| limb[p as usize]);
            limb.push(match part.map(|p| p.part) {
                Some(Part::Hips | Part::Spine | Part::Collar) => Limb::Trunk,
                Some(Part::UpperLeg) => Limb::Thigh,
                Some(Part::LowerLeg) => Limb::Calf,
                Some(_) => Limb::Other,
                // A breast's or a twist bone's name says nothing here: it belongs where it hangs.
                None => parent.unwrap_or(Limb::Other),
            });
        }
        let mut person = Self {
            limb,
            hips,
            up: up / height,
            front: front / height,
            middle: 0.0,
        };
        let skin = body.skin.positions.iter().zip(body.skinning.iter());
        let trunk = skin.filter(|(p, row)| {
            let height = person.up.dot(**p - hips);
            person.share(row, Limb::Trunk) > 0.7 && (0.0..1.0).contains(&height)
        });
        let depths = trunk.map(|(p, _)| person.front.dot(*p - hips));
        let (back, front) = depths.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| {
            (low.min(d), high.max(d))
        });
        (back < front).then(|| {
            person.middle = 0.5 * (back + front);
            person
        })
    }

    /// Share of each region, in the order of [`BodyRegion::ALL`], of a point with these bones; at most 1 in all.
    pub fn shares(&self, point: DVec3, bones: &[SkinWeight]) -> [f64; 5] {
        let height = self.up.dot(point - self.hips);
        let in_front = step(self.front.dot(point - self.hips) - self.middle);
        let [trunk, thigh, calf] =
            [Limb::Trunk, Limb::Thigh, Limb::Calf].map(|limb| self.share(bones, limb));
        let between = |[low, high]: [f64; 2]| step(height - low) * step(high - height);
        let buttock = (trunk + thigh) * (1.0 - in_front) * between(BUTTOCK);
        [
            trunk * in_front * between(BREAST),
            trunk * in_front * between(BELLY),
            buttock,
            thigh * (1.0 - (1.0 - in_front) * between(BUTTOCK)),
            calf,
        ]
    }

    fn share(&self, bones: &[SkinWeight], limb: Limb) -> f64 {
        let own = bones.iter().filter(|w| self.limb[w.bone as usize] == limb);
        own.map(|w| w.weight).sum()
    }
}

/// 0 below −EDGE/2, 1 above EDGE/2, smooth between.
fn step(x: f64) -> f64 {
    let t = (x / EDGE + 0.5).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limb as SoftLimb;

    #[test]
    fn a_limb_is_no_person() {
        assert!(Person::of(&SoftLimb::S.body().unwrap()).is_none());
    }
}
