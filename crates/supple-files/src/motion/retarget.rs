//! Poses of one skeleton on another.

use super::bone_map::BoneMap;
use super::fit::{Rule, Seen, best_rotation, fit_rotations, snapped, swing};
use super::pose::BonePose;
use super::retarget_options::{Align, RetargetOptions, SourceSkeleton};
use glam::{DMat3, DVec3};
use supple::model::{Frame, Skeleton, UpAxis};
use supple::{Error, Result};
use supple_bake::{BodyPart, Finger, Part, body_parts, skeleton_parts};

/// Poses of one skeleton on another.
///
/// Let A turn the motion's rest pose to the avatar's bind pose as a whole, C turn the motion's world so
/// that up is up, and D_j be the rotations that bring the avatar from its bind pose to the motion's rest
/// pose. A bone of the motion that is turned by G away from its rest pose then turns the avatar's by
///
/// R_j = C G A⁻¹ D_j:
///
/// with the motion at rest, G = I and C = A, the avatar takes the motion's rest pose, and from there it
/// turns as the motion does. Poses of joints without rotations are fitted by the avatar's own bones.
#[derive(Clone, Debug)]
pub struct Retarget {
    pub(super) skeleton: Skeleton,
    map: BoneMap,
    /// For each bone of the avatar: what drives it, and what follows it in the motion alone.
    pub(super) source: Vec<Option<usize>>,
    tip: Vec<Option<usize>>,
    pub(super) parts: Vec<Option<BodyPart>>,
    /// The bone whose place follows the motion.
    root: Option<usize>,
    /// C.
    pub(super) world: DMat3,
    /// A⁻¹ D_j.
    pub(super) rest: Vec<DMat3>,
    pub(super) scale: f64,
    standing: DMat3,
    up: DVec3,
}

impl Retarget {
    /// Prepares `source`'s motion for `skeleton`.
    ///
    /// # Errors
    /// [`Error::Invalid`] as [`BoneMap::new`], and of a scale or an up direction that is none.
    pub fn new(
        source: &SourceSkeleton,
        skeleton: &Skeleton,
        options: &RetargetOptions,
    ) -> Result<Self> {
        if options.scale.is_some_and(|s| !(s > 0.0 && s.is_finite())) {
            return Err(Error::invalid("scale", "must be positive"));
        }
        if (options.up.length() - 1.0).abs() > 1e-6 || !options.up.is_finite() {
            return Err(Error::invalid("up", "must be a unit vector"));
        }
        let map = BoneMap::new(&source.names, skeleton, &options.map)?;
        let mut drives = vec![None; skeleton.len()];
        map.pairs.iter().for_each(|&(s, t)| drives[t] = Some(s));
        let parts = skeleton_parts(skeleton);
        let mut this = Self {
            root: root(skeleton, &parts, &drives),
            tip: tips(source, &map, &drives),
            source: drives,
            world: source
                .world_up
                .map_or(DMat3::IDENTITY, |up| swing(up.direction(), options.up)),
            rest: vec![DMat3::IDENTITY; skeleton.len()],
            scale: options.scale.unwrap_or(1.0),
            standing: (source.rest_up)
                .map_or(DMat3::IDENTITY, |rest| swing(rest.direction(), options.up)),
            up: options.up,
            skeleton: skeleton.clone(),
            map,
            parts,
        };
        let rest = |t: usize| source.rest_joints.get(this.source[t]?).copied().flatten();
        let places: Vec<Option<DVec3>> = (0..skeleton.len()).map(rest).collect();
        let own_up = options.avatar_up.map(UpAxis::direction);
        if places.iter().all(Option::is_none) {
            // A⁻¹: unturned is the bind pose that stands in the motion's rest pose, or else in its world.
            if let Some(own) = own_up {
                let up = source.rest_up.or(source.world_up);
                let up = up.map_or(options.up, UpAxis::direction);
                this.rest.fill(swing(own, up));
                this.standing = swing(own, options.up);
            }
            return Ok(this);
        }
        // A from the mapped joints about their centres.
        let whole = best_rotation(&centred(skeleton, &places)).map_or(DMat3::IDENTITY, snapped);
        let seen_up = source.rest_up.map(|rest| whole * rest.direction());
        if let Some(own) = own_up.or(seen_up) {
            this.standing = swing(own, options.up);
        }
        if options.scale.is_none() {
            this.scale = this.relative_size(&places);
        }
        let aligned = match options.align {
            Align::None => vec![DMat3::IDENTITY; skeleton.len()],
            Align::Directions => {
                let seen = |t: usize| Seen {
                    place: places[t].map(|p| whole * p),
                    end: this.tip[t]
                        .and_then(|s| source.rest_joints.get(s).copied().flatten())
                        .map(|p| whole * p),
                    rule: this.rest_rule(t),
                };
                fit_rotations(skeleton, &(0..skeleton.len()).map(seen).collect::<Vec<_>>())
            }
        };
        this.rest = aligned.into_iter().map(|d| whole.transpose() * d).collect();
        Ok(this)
    }

    /// Takes `pose` of the motion for that in which the avatar's bind pose stands, in place of any
    /// alignment: A⁻¹ D_j = G_j⁻¹ C⁻¹ B, B standing the avatar up.
    pub fn rest_at(&mut self, pose: &[BonePose]) {
        for (t, rest) in self.rest.iter_mut().enumerate() {
            let rotation = self.source[t].and_then(|s| pose.get(s)?.rotation);
            if let Some(g) = rotation {
                *rest = DMat3::from_quat(g).transpose() * self.world.transpose() * self.standing;
            }
        }
    }

    /// Which bone drives which.
    pub fn map(&self) -> &BoneMap {
        &self.map
    }

    /// The avatar's bones that are driven, rising.
    pub fn driven(&self) -> impl Iterator<Item = usize> {
        self.map.pairs.iter().map(|pair| pair.1)
    }

    /// Metres of the avatar's way for one of the motion's.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// The direction that points up.
    pub fn up(&self) -> DVec3 {
        self.up
    }

    /// The rotation that stands the avatar's bind pose up.
    pub fn standing(&self) -> DMat3 {
        self.standing
    }

    /// The avatar's bones that stand on the ground.
    pub(super) fn feet(&self) -> impl Iterator<Item = usize> {
        let foot =
            |p: &Option<BodyPart>| p.is_some_and(|p| matches!(p.part, Part::Foot | Part::Toes));
        (self.parts.iter().enumerate())
            .filter(move |(_, p)| foot(p))
            .map(|(j, _)| j)
    }

    /// The avatar's bone whose place follows the motion: the pelvis; without one what the legs hang on, the first driven
    /// bone that is part of a body, or the first. What is above it, a root on the floor, follows it.
    pub fn root(&self) -> Option<usize> {
        self.root
    }

    /// The root if its place is known, else the first driven bone whose place is.
    pub(super) fn anchor(&self, pose: &[BonePose]) -> Option<usize> {
        let known = |t: &usize| self.place(pose, *t).is_some();
        self.root
            .filter(known)
            .or_else(|| self.driven().find(known))
    }

    /// Where the motion has the avatar's bone `t`, in the avatar's world and size.
    pub(super) fn place(&self, pose: &[BonePose], t: usize) -> Option<DVec3> {
        let position = pose.get(self.source[t]?)?.position?;
        Some(self.scale * (self.world * position))
    }

    /// World frames of the avatar's bones in `pose`, a [`BonePose`] for each of the motion's bones. Bones
    /// that are not driven keep their rotation to their parent, and those above all that are driven follow
    /// the first. Without any known place the root's joint is at the origin.
    pub fn frames(&self, pose: &[BonePose]) -> Vec<Frame> {
        let turned = |t: usize| pose.get(self.source[t]?)?.rotation.map(DMat3::from_quat);
        let driven: Vec<Option<DMat3>> = if self.driven().any(|t| turned(t).is_some()) {
            (0..self.skeleton.len())
                .map(|t| Some(self.world * turned(t)? * self.rest[t]))
                .collect()
        } else {
            let seen = |t: usize| Seen {
                place: self.place(pose, t),
                end: self.tip[t]
                    .and_then(|s| pose.get(s)?.position)
                    .map(|p| self.scale * (self.world * p)),
                rule: Rule::Directions,
            };
            let seen: Vec<Seen> = (0..self.skeleton.len()).map(seen).collect();
            let fitted = fit_rotations(&self.skeleton, &seen).into_iter();
            fitted
                .zip(&seen)
                .map(|(r, s)| s.place.and(Some(r)))
                .collect()
        };
        let first = driven.iter().flatten().next().copied();
        let mut rotations: Vec<DMat3> = Vec::with_capacity(self.skeleton.len());
        for (j, rotation) in driven.into_iter().enumerate() {
            let above = match self.skeleton.parents[j] {
                Some(p) => rotations[p as usize],
                None => first.unwrap_or(DMat3::IDENTITY),
            };
            rotations.push(rotation.unwrap_or(above));
        }
        let mut frames = place_joints(&self.skeleton, &rotations);
        if let Some(anchor) = self.anchor(pose)
            && let Some(place) = self.place(pose, anchor)
        {
            let shift = place - frames[anchor].position;
            frames.iter_mut().for_each(|f| f.position += shift);
        }
        frames
    }

    /// How the rest pose turns the avatar's bone `t`.
    fn rest_rule(&self, t: usize) -> Rule {
        let children = self.driven();
        let children = children.filter(|&c| self.skeleton.parents[c] == Some(t as u32));
        let parts: Vec<Option<Part>> = children.map(|c| self.parts[c].map(|p| p.part)).collect();
        match self.parts[t].map(|p| p.part) {
            Some(
                Part::Hips | Part::Spine | Part::Neck | Part::Head | Part::Collar | Part::Toes,
            ) => Rule::Inherit,
            // Where the toes are tells how a foot is held; without them the sole stays flat.
            Some(Part::Foot) if parts.is_empty() => Rule::Rest,
            // One finger does not tell how a hand is held.
            Some(Part::Hand) if parts.len() < 2 => Rule::Inherit,
            // A bone of the pelvis or the chest that goes by another name.
            None if parts
                .iter()
                .any(|p| matches!(p, Some(Part::UpperLeg | Part::Collar | Part::UpperArm))) =>
            {
                Rule::Inherit
            }
            _ => Rule::Directions,
        }
    }

    /// Avatar to motion: by the legs, else by the spread of joints about their centre.
    pub(super) fn relative_size(&self, places: &[Option<DVec3>]) -> f64 {
        let find = |leg: BodyPart, part: Part| {
            let wanted = Some(BodyPart {
                side: leg.side,
                part,
            });
            self.parts.iter().position(|p| *p == wanted)
        };
        let length = |leg: BodyPart| -> Option<(f64, f64)> {
            let [hip, knee, foot] =
                [Part::UpperLeg, Part::LowerLeg, Part::Foot].map(|part| find(leg, part));
            let (hip, knee, foot) = (hip?, knee?, foot?);
            let over = |at: &dyn Fn(usize) -> Option<DVec3>| {
                Some((at(hip)? - at(knee)?).length() + (at(knee)? - at(foot)?).length())
            };
            Some((
                over(&|j| Some(self.skeleton.joints[j]))?,
                over(&|j| places[j])?,
            ))
        };
        let legs = (self.parts.iter().flatten())
            .filter(|p| p.part == Part::UpperLeg)
            .filter_map(|p| length(*p));
        let legs = legs.fold((0.0, 0.0), |sum, l| (sum.0 + l.0, sum.1 + l.1));
        let centred = centred(&self.skeleton, places);
        let spread = centred.iter().fold((0.0, 0.0), |sum, (motion, avatar)| {
            (
                sum.0 + avatar.length_squared(),
                sum.1 + motion.length_squared(),
            )
        });
        let ratio =
            |(avatar, motion): (f64, f64)| (avatar > 0.0 && motion > 0.0).then(|| avatar / motion);
        ratio(legs)
            .or(ratio(spread).map(f64::sqrt))
            .filter(|r| r.is_finite())
            .unwrap_or(1.0)
    }
}

/// Which of the bones that something `drives` is placed where the motion has it; see [`Retarget::root`].
fn root(
    skeleton: &Skeleton,
    parts: &[Option<BodyPart>],
    drives: &[Option<usize>],
) -> Option<usize> {
    let driven = || (0..drives.len()).filter(|&t| drives[t].is_some());
    let is = |t: usize, part: Part| parts[t].is_some_and(|p| p.part == part);
    let above = |t: usize| {
        let parent = |t: &usize| skeleton.parents[*t].map(|p| p as usize);
        std::iter::successors(parent(&t), parent)
    };
    let mut legs = driven().filter(|&t| is(t, Part::UpperLeg));
    let legs = (legs.next(), legs.next());
    let forked = || {
        let (left, right) = (legs.0?, legs.1?);
        above(left).find(|&t| drives[t].is_some() && above(right).any(|r| r == t))
    };
    (driven().find(|&t| is(t, Part::Hips)))
        .or_else(forked)
        .or_else(|| driven().find(|&t| parts[t].is_some()))
        .or_else(|| driven().next())
}

/// Places of the motion's joints and of the avatar's that they drive, each about the centre of all.
fn centred(skeleton: &Skeleton, places: &[Option<DVec3>]) -> Vec<(DVec3, DVec3)> {
    let known: Vec<(DVec3, DVec3)> = (skeleton.joints.iter().zip(places))
        .filter_map(|(j, p)| Some(((*p)?, *j)))
        .collect();
    let middle = known.iter().fold((DVec3::ZERO, DVec3::ZERO), |sum, k| {
        (sum.0 + k.0, sum.1 + k.1)
    });
    let count = known.len() as f64;
    (known.iter())
        .map(|k| (k.0 - middle.0 / count, k.1 - middle.1 / count))
        .collect()
}

/// Frames of `skeleton` with these world rotations, the root's joint at the origin.
fn place_joints(skeleton: &Skeleton, rotations: &[DMat3]) -> Vec<Frame> {
    let local: Vec<DMat3> = (rotations.iter().zip(&skeleton.parents))
        .map(|(r, parent)| parent.map_or(*r, |p| rotations[p as usize].transpose() * *r))
        .collect();
    skeleton.forward_kinematics(&local, DVec3::ZERO)
}

/// For each last bone of a finger that is driven: the motion's bone that comes after it.
fn tips(source: &SourceSkeleton, map: &BoneMap, drives: &[Option<usize>]) -> Vec<Option<usize>> {
    let parts = body_parts(&source.names);
    let after = |finger: Finger, level: u8, side| {
        let part = Part::Finger(finger, level + 1);
        parts
            .iter()
            .position(|p| *p == Some(BodyPart { side, part }))
    };
    let free = |s: &usize| !map.pairs.iter().any(|pair| pair.0 == *s);
    let tip = |s: &Option<usize>| match parts[(*s)?]? {
        BodyPart {
            side,
            part: Part::Finger(finger, level),
        } => after(finger, level, side).filter(free),
        _ => None,
    };
    drives.iter().map(tip).collect()
}
