//! The bones' tree and its forward kinematics.

use super::{Frame, JointRange};
use crate::{Error, Result};
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use std::collections::HashSet;

/// Trees of bones. Parents come before their children; a root has none. The first bone is the avatar's
/// root; rigid bodies are further ones.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Skeleton {
    /// Names, unique.
    pub names: Vec<String>,
    /// Parent of each bone.
    pub parents: Vec<Option<u32>>,
    /// J: each joint's place in the reference shape, m.
    pub joints: Vec<DVec3>,
    /// Further names of bones, such as VRM's humanoid ones.
    pub aliases: Vec<(String, u32)>,
    /// How far joints turn, by bone; a bone without an entry turns freely.
    pub limits: Vec<(u32, JointRange)>,
}

impl Skeleton {
    /// Number of bones.
    pub fn len(&self) -> usize {
        self.joints.len()
    }

    /// Whether there is no bone.
    pub fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    /// Index of the bone called `name`; names go before aliases.
    pub fn find(&self, name: &str) -> Option<usize> {
        let alias = || self.aliases.iter().find(|(alias, _)| alias == name);
        (self.names.iter().position(|n| n == name)).or_else(|| alias().map(|(_, j)| *j as usize))
    }

    /// The bones of these names; `field` is where they stand, for errors.
    ///
    /// # Errors
    /// [`Error::Invalid`] where one is not there.
    pub fn named(&self, names: &[String], field: &str) -> Result<Vec<u32>> {
        let bone = |name: &String| {
            self.find(name).map(|b| b as u32).ok_or_else(|| {
                let known = self.names.join(", ");
                let problem = format!("no bone is called {name:?}; there are {known}");
                Error::invalid(field, problem)
            })
        };
        names.iter().map(bone).collect()
    }

    /// The first `count` bones alone.
    pub fn first(&self, count: usize) -> Self {
        let known = |alias: &&(String, u32)| (alias.1 as usize) < count;
        Self {
            names: self.names[..count].to_vec(),
            parents: self.parents[..count].to_vec(),
            joints: self.joints[..count].to_vec(),
            aliases: self.aliases.iter().filter(known).cloned().collect(),
            limits: (self
                .limits
                .iter()
                .filter(|l| (l.0 as usize) < count)
                .copied())
            .collect(),
        }
    }

    /// Frames in the bind pose: no rotation, each at its joint.
    pub fn bind_pose(&self) -> Vec<Frame> {
        self.joints
            .iter()
            .map(|&position| Frame {
                rotation: DMat3::IDENTITY,
                position,
            })
            .collect()
    }

    /// World frames from each bone's rotation relative to its parent (a root's relative to the
    /// world), the first root's joint standing at `root_position` and further ones' where they are in the
    /// reference shape.
    pub fn forward_kinematics(
        &self,
        local_rotations: &[DMat3],
        root_position: DVec3,
    ) -> Vec<Frame> {
        let mut frames: Vec<Frame> = Vec::with_capacity(self.len());
        for (j, &local) in local_rotations.iter().enumerate() {
            frames.push(match self.parents[j] {
                None => Frame {
                    rotation: local,
                    position: if j == 0 {
                        root_position
                    } else {
                        self.joints[j]
                    },
                },
                Some(p) => {
                    let parent = frames[p as usize];
                    Frame {
                        rotation: parent.rotation * local,
                        position: parent.transform(self.joints[j] - self.joints[p as usize]),
                    }
                }
            });
        }
        frames
    }

    /// Checks lengths, finiteness and that parents precede children.
    pub fn validate(&self) -> Result<()> {
        let count = self.len();
        if count == 0 || self.names.len() != count || self.parents.len() != count {
            return Err(Error::invalid(
                "skeleton",
                format!(
                    "{} names, {} parents, {count} joints",
                    self.names.len(),
                    self.parents.len()
                ),
            ));
        }
        if self
            .parents
            .iter()
            .enumerate()
            .any(|(j, p)| p.is_some_and(|p| p as usize >= j))
        {
            return Err(Error::invalid(
                "skeleton.parents",
                "a bone stands before its parent",
            ));
        }
        let distinct: HashSet<&String> = self.names.iter().collect();
        if distinct.len() != count {
            return Err(Error::invalid("skeleton.names", "two bones share a name"));
        }
        if self.aliases.iter().any(|(_, j)| *j as usize >= count) {
            let problem = "one names a bone that is not there";
            return Err(Error::invalid("skeleton.aliases", problem));
        }
        for &(bone, range) in &self.limits {
            let field = format!("skeleton.limits[{bone}]");
            if self.parents.get(bone as usize).is_none_or(Option::is_none) {
                let problem = "there is no such bone, or it has no parent";
                return Err(Error::invalid(field, problem));
            }
            range.validate(&field)?;
        }
        if self.joints.iter().any(|j| !j.is_finite()) {
            return Err(Error::invalid(
                "skeleton.joints",
                "holds a value that is not finite",
            ));
        }
        Ok(())
    }
}

/// SMPL's pose feature: R_parentᵀ R_child − I of every bone but the roots, nine numbers each, row by
/// row (Loper et al. 2015). Bones are in skeleton order.
pub fn pose_feature(parents: &[Option<u32>], frames: &[Frame]) -> Vec<f64> {
    pose_features(parents, frames).collect()
}

/// [`pose_feature`] into a vector that is kept.
pub fn pose_feature_into(parents: &[Option<u32>], frames: &[Frame], out: &mut Vec<f64>) {
    out.clear();
    out.extend(pose_features(parents, frames));
}

/// [`pose_feature`], number by number.
pub fn pose_features(parents: &[Option<u32>], frames: &[Frame]) -> impl Iterator<Item = f64> {
    parents.iter().zip(frames).flat_map(|(parent, frame)| {
        let relative = parent.map(|p| frames[p as usize].rotation.transpose() * frame.rotation);
        // Rows of the relative rotation are columns of its transpose.
        let change = relative.map(|r| (r - DMat3::IDENTITY).transpose().to_cols_array());
        change.into_iter().flatten()
    })
}
