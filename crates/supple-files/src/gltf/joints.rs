//! The list of a file's joints: what a host calls its nodes, and the bone of each.

use super::container::File;
use super::nodes::Nodes;
use super::primitive::Part;
use super::rig::{Rig, unique_name};
use glam::DAffine3;
use std::collections::{BTreeMap, BTreeSet};
use supple::Result;
use supple::model::{Joint, JointBone, JointList, SkinJoints};

impl Rig {
    /// The joints of the skin of most vertices in its own order, then those of the others, then the nodes that parts without
    /// a skin hang on, then bones that are none of these: F = (R, c)⁻¹ · world, both at rest. A skin that the scene does not
    /// show has none.
    pub fn joints(&self, file: &File, nodes: &Nodes, parts: &[Part]) -> Result<JointList> {
        let document = &file.document;
        let of_skins = (self.largest_first.iter()).flat_map(|&s| &document.skins[s].joints);
        let hanging = parts.iter().filter(|p| p.skin.is_none()).map(|p| &p.node);
        let mut taken: BTreeSet<String> = self.skeleton.names.iter().cloned().collect();
        let mut place: BTreeMap<usize, u32> = BTreeMap::new();
        let mut joints: Vec<Joint> = Vec::new();
        for &node in of_skins.chain(hanging).chain(&self.nodes) {
            let Some(bone) = self.bone_above(nodes, node) else {
                continue;
            };
            if place.contains_key(&node) {
                continue;
            }
            place.insert(node, joints.len() as u32);
            let is = self.bone_of_node[node] == Some(bone);
            let rest = &self.rest[bone as usize];
            let frame = DAffine3 {
                matrix3: rest.rotation,
                translation: rest.position,
            };
            joints.push(Joint {
                name: match is {
                    true => self.skeleton.names[bone as usize].clone(),
                    false => unique_name(file, node, &mut taken),
                },
                bone: match is {
                    true => JointBone::Is(bone),
                    false => JointBone::RidesOn(bone),
                },
                bind: frame.inverse() * nodes.rest_with_inverse(node),
            });
        }
        let skin = |s: usize| match self.skins.get(&s) {
            None => SkinJoints::default(),
            Some(bound) => SkinJoints {
                joints: document.skins[s].joints.iter().map(|n| place[n]).collect(),
                inverse_binds: bound.inverse_binds.clone(),
            },
        };
        let skins = (0..document.skins.len()).map(skin).collect();
        let list = JointList::new(self.skeleton.len(), joints, skins);
        list.map_err(|e| e.of_file(&file.path))
    }
}
