//! The bones of a file's motions: those of its body, and whatever else is moved.

use super::bone_nodes::{moved, whole_trees, with_between};
use super::bone_tree::BoneTree;
use super::container::File;
use super::nodes::Nodes;
use super::rig::{Rig, unique_name};
use super::vrm::animated_humanoid;
use glam::{DMat3, DVec3};
use std::collections::{BTreeMap, BTreeSet};
use supple::Result;
use supple::model::Frame;

/// More bones than any motion has.
const MOST_BONES: usize = 4096;

/// Bones that animations move, parents before children.
#[derive(Debug)]
pub(super) struct MotionBones {
    pub names: Vec<String>,
    /// The node of each.
    pub nodes: Vec<usize>,
    pub parents: Vec<Option<u32>>,
    /// J, as of the file's body where it has one.
    pub joints: Vec<DVec3>,
    /// R and c in the file's rest pose.
    pub rest: Vec<Frame>,
}

impl MotionBones {
    /// The bones of the file's animations; `rig` is that of its body, if it shows one.
    pub fn new(file: &File, nodes: &Nodes, rig: Option<&Rig>) -> Result<Self> {
        let mut humanoid: BTreeMap<usize, String> = BTreeMap::new();
        for (name, node) in animated_humanoid(file) {
            if let Some(n) = node.filter(|&n| n < nodes.parents.len()) {
                humanoid.entry(n).or_insert(name);
            }
        }
        let chosen = choose(file, nodes, rig, &humanoid);
        if chosen.len() > MOST_BONES {
            let count = chosen.len();
            let problem =
                format!("move {count} nodes; {MOST_BONES} at most are read: split the file");
            return Err(file.broken("animations", problem));
        }
        let none = vec![0.0; nodes.parents.len()];
        let tree = BoneTree::new(file, nodes, &chosen, rig.map_or(&none, |r| &r.weight));
        let (bones, parents) = tree.map_or_else(Default::default, |t| (t.nodes, t.parents));
        let mut joints: Vec<DVec3> = Vec::with_capacity(bones.len());
        let mut rest: Vec<Frame> = Vec::with_capacity(bones.len());
        for (&n, parent) in bones.iter().zip(&parents) {
            let position = nodes.rest_world[n].translation;
            let of_body = rig.and_then(|r| Some((r, r.bone_of_node[n]? as usize)));
            // What the body does not have is as its parent is, J_j = J_p + R_pᵀ (c_j − c_p).
            let above = parent.map(|p| (joints[p as usize], rest[p as usize]));
            let (joint, rotation) = match (of_body, above) {
                (Some((rig, bone)), _) => (rig.skeleton.joints[bone], rig.rest[bone].rotation),
                (None, Some((joint, frame))) => {
                    (joint + frame.inverse_transform(position), frame.rotation)
                }
                (None, None) => (position, DMat3::IDENTITY),
            };
            joints.push(joint);
            rest.push(Frame { rotation, position });
        }
        Ok(Self {
            names: names(file, rig, humanoid, &bones),
            nodes: bones,
            parents,
            joints,
            rest,
        })
    }
}

/// The bones of the body, the nodes that are moved, and those between. Where no skin says what the skeleton is, all nodes of
/// the trees that are moved: where a bone's children are tells how it is held. A VRM animation says itself which nodes are
/// bones.
fn choose(
    file: &File,
    nodes: &Nodes,
    rig: Option<&Rig>,
    humanoid: &BTreeMap<usize, String>,
) -> BTreeSet<usize> {
    let body: BTreeSet<usize> = rig.into_iter().flat_map(|r| r.nodes.clone()).collect();
    if !humanoid.is_empty() {
        return with_between(nodes, &body, &humanoid.keys().copied().collect());
    }
    let moved = moved(file);
    let bones = with_between(nodes, &body, &moved);
    if rig.is_some_and(|r| !r.skins.is_empty()) {
        return bones;
    }
    let whole: BTreeSet<usize> = bones.union(&whole_trees(nodes, &moved)).copied().collect();
    match whole.len() <= MOST_BONES {
        true => whole,
        false => bones,
    }
}

/// VRM's names, else the body's own, else those of the nodes; each once.
fn names(
    file: &File,
    rig: Option<&Rig>,
    humanoid: BTreeMap<usize, String>,
    bones: &[usize],
) -> Vec<String> {
    let mut taken: BTreeSet<String> = humanoid.values().cloned().collect();
    let mut known = humanoid;
    let body = rig
        .into_iter()
        .flat_map(|r| r.nodes.iter().zip(&r.skeleton.names));
    for (&n, name) in body {
        if !known.contains_key(&n) && taken.insert(name.clone()) {
            known.insert(n, name.clone());
        }
    }
    let name = |n: &usize| {
        known
            .remove(n)
            .unwrap_or_else(|| unique_name(file, *n, &mut taken))
    };
    bones.iter().map(name).collect()
}
