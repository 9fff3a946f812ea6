//! Spring bones: hair, skirts, ears and tails that lag behind what carries them and swing back.
//!
//! The terms are those of VRMC_springBone-1.0 (VRM consortium), which VRM 0.x has as `secondaryAnimation`. What they do
//! in a step is in `sim/spring_bones.rs`.

use crate::{Error, Result};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// What no hair needs more of: stiffness and gravity, m/s; lengths, m.
const MOST: f64 = 1e6;

/// The spring bones of an avatar: carried bones ([`Avatar::is_carried`](super::Avatar::is_carried)) that swing.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SpringBones {
    /// The chains, in the file's order.
    pub chains: Vec<SpringChain>,
    /// The joints of all chains, their bones rising: so parents come before their children.
    pub joints: Vec<SpringJoint>,
    /// What chains may collide with.
    pub colliders: Vec<SpringCollider>,
}

/// Joints that a file tells of together.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SpringChain {
    /// Its name in the file, or that of its first joint.
    pub name: String,
    /// The bone in whose space inertia is felt: what it does itself leaves the chain at rest. None: the world's.
    pub center: Option<u32>,
    /// What the chain's joints collide with: indices into [`SpringBones::colliders`], those of all its collider groups.
    pub colliders: Vec<u32>,
}

/// A joint that turns so that its tail swings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpringJoint {
    /// Which of [`SpringBones::chains`] it belongs to.
    pub chain: u32,
    /// The bone that it turns; its parent carries it.
    pub bone: u32,
    /// The tail, the next joint of the chain: from the bone's joint, in the bone's frame, m.
    pub tail: DVec3,
    /// The bone's rotation in the frame of its parent as the file has it at rest.
    pub rest_rotation: DMat3,
    /// What draws the tail to where it is at rest, m/s: the speed that a sixtieth of a second adds.
    pub stiffness: f64,
    /// Part of the tail's velocity that is lost in a sixtieth of a second, 0 to 1.
    pub drag_force: f64,
    /// Gravity power times direction, in the axes of the avatar's file, m/s: the velocity that a sixtieth of a second adds.
    pub gravity: DVec3,
    /// Radius of the ball about the tail that collides, m.
    pub hit_radius: f64,
}

/// A sphere or capsule that is fixed to a bone and that spring bones do not enter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpringCollider {
    /// The bone.
    pub bone: u32,
    /// Middle of the sphere, or of the capsule's first end: from the bone's joint, in the bone's frame, m.
    pub offset: DVec3,
    /// Middle of the capsule's other end; nothing for a sphere.
    pub tail: Option<DVec3>,
    /// Radius, m.
    pub radius: f64,
}

impl SpringBones {
    /// Whether nothing swings.
    pub fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    /// The joint that turns `bone`.
    pub fn of_bone(&self, bone: usize) -> Option<&SpringJoint> {
        let at = self
            .joints
            .binary_search_by_key(&bone, |joint| joint.bone as usize);
        at.ok().map(|at| &self.joints[at])
    }

    /// Makes everything `factor` times as large; it swings as before.
    pub fn scale(&mut self, factor: f64) {
        for joint in &mut self.joints {
            joint.tail *= factor;
            joint.gravity *= factor;
            joint.stiffness *= factor;
            joint.hit_radius *= factor;
        }
        for collider in &mut self.colliders {
            collider.offset *= factor;
            (collider.tail.iter_mut()).for_each(|tail| *tail *= factor);
            collider.radius *= factor;
        }
    }

    /// Keeps the joints for which `keep` holds, with the chains and colliders that they need. Tells how many go.
    pub fn retain_joints(&mut self, keep: impl FnMut(&SpringJoint) -> bool) -> usize {
        let before = self.joints.len();
        self.joints.retain(keep);
        let gone = before - self.joints.len();
        let mut used = vec![false; self.chains.len()];
        (self.joints.iter()).for_each(|joint| used[joint.chain as usize] = true);
        let number = retain(&mut self.chains, &used);
        (self.joints.iter_mut()).for_each(|joint| joint.chain = number[joint.chain as usize]);
        let mut used = vec![false; self.colliders.len()];
        let colliders = self.chains.iter().flat_map(|chain| &chain.colliders);
        colliders.for_each(|&collider| used[collider as usize] = true);
        let number = retain(&mut self.colliders, &used);
        let colliders = self
            .chains
            .iter_mut()
            .flat_map(|chain| &mut chain.colliders);
        colliders.for_each(|collider| *collider = number[*collider as usize]);
        gone
    }

    /// Checks every index and number against the `parents` of the bones. As every `validate` of a value that others hold,
    /// it names the field as seen from the value.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the field.
    pub fn validate(&self, parents: &[Option<u32>]) -> Result<()> {
        let check = |ok: bool, field: String, problem: &str| match ok {
            true => Ok(()),
            false => Err(Error::invalid(field, problem)),
        };
        let bones = parents.len();
        for (i, chain) in self.chains.iter().enumerate() {
            let colliders = chain.colliders.iter();
            check(
                colliders
                    .max()
                    .is_none_or(|&c| (c as usize) < self.colliders.len()),
                format!("chains[{i}].colliders"),
                "names a collider that is not there",
            )?;
        }
        for (i, joint) in self.joints.iter().enumerate() {
            let field = |key: &str| format!("joints[{i}].{key}");
            check(
                parents
                    .get(joint.bone as usize)
                    .is_some_and(Option::is_some),
                field("bone"),
                "there is no such bone, or it has no parent",
            )?;
            check(
                i == 0 || self.joints[i - 1].bone < joint.bone,
                field("bone"),
                "bones must rise",
            )?;
            let chain = self.chains.get(joint.chain as usize);
            check(
                chain.is_some_and(|chain| chain.center.is_none_or(|center| center < joint.bone)),
                field("chain"),
                "there is no such chain, or its center does not come before the bone",
            )?;
            let within = |v: DVec3| v.is_finite() && v.abs().max_element() <= MOST;
            let length = joint.tail.length();
            check(
                within(joint.tail) && length > 0.0,
                field("tail"),
                "is no place apart from the joint",
            )?;
            check(
                super::is_rotation(&joint.rest_rotation),
                field("rest_rotation"),
                "is no rotation",
            )?;
            let numbers = [
                ("stiffness", joint.stiffness),
                ("hit_radius", joint.hit_radius),
            ];
            for (key, value) in numbers {
                let problem = "must be zero or positive, and 1e6 at most";
                check((0.0..=MOST).contains(&value), field(key), problem)?;
            }
            check(
                (0.0..=1.0).contains(&joint.drag_force),
                field("drag_force"),
                "must be 0 to 1",
            )?;
            check(
                within(joint.gravity),
                field("gravity"),
                "must be finite, and 1e6 at most",
            )?;
        }
        for (i, collider) in self.colliders.iter().enumerate() {
            let places = [Some(collider.offset), collider.tail];
            check(
                (collider.bone as usize) < bones
                    && places.into_iter().flatten().all(|p| p.is_finite())
                    && (0.0..f64::INFINITY).contains(&collider.radius),
                format!("colliders[{i}]"),
                "needs a bone, finite places and a radius that is not negative",
            )?;
        }
        Ok(())
    }
}

/// Keeps the values that are `used`; the new number of each.
fn retain<T>(values: &mut Vec<T>, used: &[bool]) -> Vec<u32> {
    let mut count = 0;
    let number = used.iter().map(|&used| {
        count += u32::from(used);
        count.saturating_sub(1)
    });
    let number = number.collect();
    let mut at = used.iter();
    values.retain(|_| at.next().is_some_and(|used| *used));
    number
}
