//! The joints of a character's file: the nodes that a host's own skeleton has, and the bone that goes with each.
//!
//! A host knows its nodes by the file's order and moves them by world matrices W, with whatever rotations and scale the
//! file binds them in. This crate's bones are rigid frames, turned away from the reference shape. Between the two stands
//! one constant matrix for each joint, F ([`Joint::bind`]), its placement in the frame of its bone:
//!
//! W = \[R | c\] F.
//!
//! F has the uniform scale of the file's nodes (an armature may be scaled by 0.01). A joint *is* a bone or *rides on*
//! one; both have F, so that a joint may become a rider without any change for the host.

use super::Skeleton;
use crate::{Error, Result};
use glam::{DAffine3, DVec3};
use serde::{Deserialize, Serialize};
use std::collections::HashSet;

/// What a joint has to do with the bones.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum JointBone {
    /// It is this bone: the host's matrix moves it.
    Is(u32),
    /// It is fixed to this bone and follows it; the host's matrix is not read.
    RidesOn(u32),
}

impl JointBone {
    /// The bone that it is or rides on.
    pub fn bone(self) -> usize {
        match self {
            Self::Is(bone) | Self::RidesOn(bone) => bone as usize,
        }
    }
}

/// A named node of a character's file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Joint {
    /// Its name in the file, with a number where another joint has the same.
    pub name: String,
    /// The bone that it is or rides on.
    pub bone: JointBone,
    /// F: its placement in the frame of that bone; of one that is a bone a rotation (or mirror) with a uniform scale.
    pub bind: DAffine3,
}

/// A skin of a character's file, in the file's order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SkinJoints {
    /// Indices into [`JointList::joints`]; none where the file's scene does not show the skin.
    pub joints: Vec<u32>,
    /// What takes the skin's mesh into the space of each joint at bind.
    pub inverse_binds: Vec<DAffine3>,
}

/// The joints of a character's file, in the order of its largest skin; after those other skins' and nodes that drawn
/// parts hang on. Where a file says nothing of joints each bone is one, with F = 1.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Stored")]
pub struct JointList {
    joints: Vec<Joint>,
    skins: Vec<SkinJoints>,
    /// For each bone the joint that is it.
    of_bone: Vec<Option<u32>>,
    /// For each skin the bones that its joints are, rising, each with the joint's place in the skin's list.
    bones_of_skin: Vec<Vec<(u32, u32)>>,
}

/// What is written of a [`JointList`].
#[derive(Serialize, Deserialize)]
struct Stored {
    bones: u32,
    joints: Vec<Joint>,
    skins: Vec<SkinJoints>,
}

impl TryFrom<Stored> for JointList {
    type Error = Error;

    fn try_from(stored: Stored) -> Result<Self> {
        Self::new(stored.bones as usize, stored.joints, stored.skins)
    }
}

impl From<JointList> for Stored {
    fn from(list: JointList) -> Self {
        Self {
            bones: list.of_bone.len() as u32,
            joints: list.joints,
            skins: list.skins,
        }
    }
}

/// More bones than any avatar has: what a damaged file may ask memory for.
const MOST_BONES: usize = 1 << 16;

impl JointList {
    /// The list of these `joints` and `skins` for a skeleton of `bones`.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the joint or skin that names what is not there, has a matrix that is not finite or has no
    /// inverse, or is a bone that another is.
    pub fn new(bones: usize, joints: Vec<Joint>, skins: Vec<SkinJoints>) -> Result<Self> {
        if bones > MOST_BONES {
            let problem = format!("{bones} bones; {MOST_BONES} at most have joints");
            return Err(Error::invalid("joints", problem));
        }
        let mut of_bone = vec![None; bones];
        let mut names = HashSet::new();
        for (j, joint) in joints.iter().enumerate() {
            let wrong = |problem: String| {
                let problem = format!("joint {:?} {problem}", joint.name);
                Err(Error::invalid(format!("joints[{j}]"), problem))
            };
            let Some(slot) = of_bone.get_mut(joint.bone.bone()) else {
                return wrong(format!("names bone {} of {bones}", joint.bone.bone()));
            };
            if !names.insert(joint.name.as_str()) {
                return wrong("has the name of another: give it one of its own".into());
            }
            if !joint.bind.is_finite() {
                return wrong("has a bind matrix that is not finite".into());
            }
            if let JointBone::Is(bone) = joint.bone {
                if !has_inverse(&joint.bind) {
                    return wrong("has a bind matrix without an inverse".into());
                }
                if slot.replace(j as u32).is_some() {
                    return wrong(format!("is bone {bone}, which another joint is"));
                }
            }
        }
        let mut bones_of_skin = Vec::with_capacity(skins.len());
        for (s, skin) in skins.iter().enumerate() {
            let sound = skin.inverse_binds.len() == skin.joints.len()
                && skin.inverse_binds.iter().all(has_inverse)
                && skin.joints.iter().all(|&j| (j as usize) < joints.len());
            if !sound {
                let problem = "needs one finite inverse bind matrix that has an inverse for each of its joints, which must \
                               be there";
                return Err(Error::invalid(format!("joints.skins[{s}]"), problem));
            }
            let is = |(k, &j): (u32, &u32)| match joints[j as usize].bone {
                JointBone::Is(bone) => Some((bone, k)),
                JointBone::RidesOn(_) => None,
            };
            let mut own: Vec<(u32, u32)> = (0..).zip(&skin.joints).filter_map(is).collect();
            own.sort_unstable();
            bones_of_skin.push(own);
        }
        Ok(Self {
            joints,
            skins,
            of_bone,
            bones_of_skin,
        })
    }

    /// Every bone of `skeleton` as its own joint, F = 1, in one skin: what stands in where a file says nothing.
    pub fn of_bones(skeleton: &Skeleton) -> Self {
        let order: Vec<u32> = (0..skeleton.len() as u32).collect();
        Self::of_bones_in_order(skeleton, &order)
    }

    /// [`JointList::of_bones`] in the order of a file: `order` has each bone once. Bones that are not there are left out.
    pub fn of_bones_in_order(skeleton: &Skeleton, order: &[u32]) -> Self {
        let there = || order.iter().filter(|&&b| (b as usize) < skeleton.len());
        let mut this = Self {
            of_bone: vec![None; skeleton.len()],
            ..Self::default()
        };
        for (j, &bone) in there().enumerate() {
            this.joints.push(Joint {
                name: skeleton
                    .names
                    .get(bone as usize)
                    .cloned()
                    .unwrap_or_default(),
                bone: JointBone::Is(bone),
                bind: DAffine3::IDENTITY,
            });
            this.of_bone[bone as usize] = Some(j as u32);
        }
        let back = |&bone: &u32| DAffine3::from_translation(-skeleton.joints[bone as usize]);
        this.skins.push(SkinJoints {
            joints: (0..this.joints.len() as u32).collect(),
            inverse_binds: there().map(back).collect(),
        });
        let pairs = this
            .of_bone
            .iter()
            .zip(0..)
            .filter_map(|(k, bone)| Some((bone, (*k)?)));
        this.bones_of_skin.push(pairs.collect());
        this
    }

    /// The joints.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// The skins, as many as the file has.
    pub fn skins(&self) -> &[SkinJoints] {
        &self.skins
    }

    /// Number of joints.
    pub fn len(&self) -> usize {
        self.joints.len()
    }

    /// Whether there is no joint.
    pub fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    /// Number of bones that the list is for.
    pub fn bones(&self) -> usize {
        self.of_bone.len()
    }

    /// Index of the joint called `name`.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|j| j.name == name)
    }

    /// The place of the joint that is `bone`, if one is: in the list, or among the joints of skin `skin`.
    pub(super) fn place_of(&self, bone: usize, skin: Option<usize>) -> Option<usize> {
        let Some(skin) = skin else {
            return self.of_bone[bone].map(|j| j as usize);
        };
        let own = &self.bones_of_skin[skin];
        let at = own.binary_search_by_key(&(bone as u32), |pair| pair.0);
        Some(own[at.ok()?].1 as usize)
    }

    /// The joints of a character that became `factor` times as large: those of a host that scales the file's root by it.
    pub fn scale(&mut self, factor: f64) {
        let scale = DAffine3::from_scale(DVec3::splat(factor));
        (self.joints.iter_mut()).for_each(|j| j.bind = scale * j.bind);
    }
}

/// Whether a matrix is finite and its inverse is.
fn has_inverse(m: &DAffine3) -> bool {
    m.is_finite() && m.matrix3.determinant() != 0.0 && m.inverse().is_finite()
}
