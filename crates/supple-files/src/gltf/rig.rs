//! One skeleton out of a file's skins, and the reference shape that goes with it.
//!
//! glTF poses a vertex v of skin s at Σ_j w_j M_j v with M_j = world_j · inverseBind_{s,j}. This crate's
//! bones are rigid: x = Σ_j w_j (R_j (X − J_j) + c_j). So that both are one:
//!
//! - c_j is where node j stands;
//! - R_j is the rotation in M_j G⁻¹, its polar factor, G being M of the skin's reference bone: whatever placement, unit,
//!   axes and stretch the file binds in (G) becomes part of X, which is in the scene's coordinates, upright and in m;
//!   a bone that is no joint of a skin has its parent's R;
//! - J_j follows from R and c at rest by the bones' tree: J_j = J_p + R_pᵀ (c_j − c_p);
//! - X is the vertex at rest with the bones' own transformation undone:
//!   X = B⁻¹ (Σ w_j M_j v − Σ w_j (c_j − R_j J_j)), B = Σ w_j R_j.
//!
//! The rest pose is so met exactly, for whatever skins share bones. Where the file's bind pose and rest
//! pose differ by rotations of bones alone, as they should, so is every other pose, and X = G v. Bones that are stretched at
//! rest, each along its axes, are as rigid as others: the stretch is in X.
//!
//! Without a skin each node that shows or moves something is a bone ([`super::bone_nodes`]), and R is 1.

use super::binding::{Binding, BoundSkin};
use super::bone_nodes;
use super::bone_tree::BoneTree;
use super::container::File;
use super::nodes::Nodes;
use super::primitive::Part;
use super::told_springs::ToldSprings;
use super::vrm::humanoid;
use glam::{DAffine3, DMat3, DVec3};
use std::collections::{BTreeMap, BTreeSet};
use supple::Result;
use supple::model::{Frame, Skeleton};

/// More bones than any character has on or below which something hangs; each has six degrees of freedom.
const MOST_BONES: usize = 1024;

/// More joints than any character has, with those that move nothing.
const MOST_JOINTS: usize = 8192;

/// The bones of a file.
#[derive(Debug)]
pub(super) struct Rig {
    pub skeleton: Skeleton,
    /// The node of each bone.
    pub nodes: Vec<usize>,
    /// The bone of each node that is one.
    pub bone_of_node: Vec<Option<u32>>,
    /// R and c of each bone in the file's rest pose.
    pub rest: Vec<Frame>,
    /// Of each node: the sum of its weights, or the vertices that are rigid on it.
    pub weight: Vec<f64>,
    pub skins: BTreeMap<usize, BoundSkin>,
    /// The skins, that of most vertices first.
    pub largest_first: Vec<usize>,
}

impl Rig {
    /// The rig of the skins that `parts` use, with the humanoid and spring bones that are no joints; of a file without skins,
    /// of the nodes that show or move something.
    pub fn new(file: &File, nodes: &Nodes, parts: &[Part]) -> Result<Self> {
        let mut vertices: BTreeMap<usize, usize> = BTreeMap::new();
        for part in parts {
            if let Some(skin) = part.skin {
                *vertices.entry(skin).or_default() += part.positions.len();
            }
        }
        // The skin of most vertices says what the reference shape is.
        let mut order: Vec<usize> = vertices.keys().copied().collect();
        order.sort_by_key(|s| std::cmp::Reverse(vertices[s]));
        let joints = |s: &usize| &file.document.skins[*s].joints;

        let mut is_bone: BTreeSet<usize> = order.iter().flat_map(joints).copied().collect();
        if let Some(joint) = is_bone.iter().find(|&&j| j >= nodes.parents.len()) {
            return Err(file.broken("skins", format!("joint {joint} is no node")));
        }
        let humanoid = humanoid(file).into_iter().filter_map(|(_, node)| node);
        is_bone.extend(humanoid.filter(|&n| n < nodes.parents.len()));
        if order.is_empty() {
            is_bone.extend(bone_nodes::rigid(file, nodes, parts));
        }
        let mut swinging = is_bone.clone();
        swinging.extend(ToldSprings::read(file, nodes).heads());
        if swinging.len() <= MOST_JOINTS {
            is_bone = swinging;
        }

        let mut weight = vec![0.0; nodes.parents.len()];
        for part in parts {
            let joints = part.skin.map(|s| joints(&s));
            for &(joint, w) in part.influences.entries() {
                weight[joints.map_or(0, |j| j[joint as usize])] += w;
            }
            if order.is_empty() {
                weight[part.node] += part.positions.len() as f64;
            }
        }
        if is_bone.len() > MOST_JOINTS {
            let problem = format!("{} joints; {MOST_JOINTS} at most are read", is_bone.len());
            return Err(file.broken("skins", problem));
        }
        let tree = BoneTree::new(file, nodes, &is_bone, &weight);
        let tree = tree
            .filter(|_| !parts.is_empty())
            .ok_or_else(|| nothing_shown(file))?;
        let mut bone_of_node = vec![None; nodes.parents.len()];
        for (bone, &n) in tree.nodes.iter().enumerate() {
            bone_of_node[n] = Some(bone as u32);
        }
        let hanging = parts.iter().filter(|p| p.skin.is_none());
        let hanging = hanging.filter_map(|p| nodes.upward(p.node).find_map(|n| bone_of_node[n]));
        let weighted = (0..).zip(&tree.nodes).filter(|(_, n)| weight[**n] > 0.0);
        let loaded = tree.count_above(weighted.map(|(bone, _)| bone).chain(hanging));
        if loaded > MOST_BONES {
            let problem = format!(
                "{loaded} bones move something or are above one that does; {MOST_BONES} at most are read: merge bones"
            );
            return Err(file.broken("skins", problem));
        }

        let mut binding = Binding {
            file,
            nodes,
            tree: &tree,
            weight: &weight,
            rotation: vec![None; tree.nodes.len()],
        };
        let mut skins: BTreeMap<usize, BoundSkin> = BTreeMap::new();
        for &s in &order {
            let bones = (joints(&s).iter().filter_map(|&n| bone_of_node[n])).collect();
            if let Some(bound) = binding.bind(s, bones)? {
                skins.insert(s, bound);
            }
        }
        let rotation = binding.rotation;

        let mut rest: Vec<Frame> = Vec::with_capacity(tree.nodes.len());
        for (bone, &n) in tree.nodes.iter().enumerate() {
            let above = tree.parents[bone].map_or(DMat3::IDENTITY, |p| rest[p as usize].rotation);
            rest.push(Frame {
                rotation: rotation[bone].unwrap_or(above),
                position: nodes.rest_world[n].translation,
            });
        }
        let mut rig = Self {
            skeleton: Skeleton {
                names: unique_names(file, &tree.nodes),
                joints: joints_of(&rest, &tree.parents),
                parents: tree.parents,
                aliases: Vec::new(),
                limits: Vec::new(),
            },
            nodes: tree.nodes,
            bone_of_node,
            rest,
            weight,
            skins,
            largest_first: order,
        };
        rig.anchor();
        for skin in rig.skins.values_mut() {
            // G = (c + R (· − J))⁻¹ M of the first joint that has G's linear part exactly.
            let linear = skin.reference.matrix3;
            let exact = (0..skin.bones.len()).find(|&k| {
                let turned = rig.rest[skin.bones[k] as usize].rotation.transpose();
                let own = turned * skin.skinning[k].matrix3;
                own.abs_diff_eq(linear, 1e-12 * linear.x_axis.length())
            });
            if let Some(k) = exact {
                let bone = skin.bones[k] as usize;
                let back = rest_transform(&rig.rest[bone], rig.skeleton.joints[bone]).inverse();
                skin.reference = back * skin.skinning[k];
            }
        }
        Ok(rig)
    }

    /// Shifts the reference shape so that the first bone with weight stands there as at rest.
    fn anchor(&mut self) {
        let weighted = |&n: &usize| self.weight[n] > 0.0;
        let first = self.nodes.iter().position(weighted).unwrap_or(0);
        let shift = self.rest[first].position - self.skeleton.joints[first];
        (self.skeleton.joints.iter_mut()).for_each(|j| *j += shift);
    }

    /// The bone that moves what hangs on `node`: its own, or the nearest above.
    pub fn bone_above(&self, nodes: &Nodes, node: usize) -> Option<u32> {
        nodes.upward(node).find_map(|n| self.bone_of_node[n])
    }
}

/// x = R (X − J) + c.
pub(super) fn rest_transform(frame: &Frame, joint: DVec3) -> DAffine3 {
    DAffine3 {
        matrix3: frame.rotation,
        translation: frame.position - frame.rotation * joint,
    }
}

/// J_j = J_p + R_pᵀ (c_j − c_p), the roots' being c.
fn joints_of(rest: &[Frame], parents: &[Option<u32>]) -> Vec<DVec3> {
    let mut joints: Vec<DVec3> = Vec::with_capacity(rest.len());
    for (frame, parent) in rest.iter().zip(parents) {
        joints.push(match parent {
            None => frame.position,
            Some(p) => joints[*p as usize] + rest[*p as usize].inverse_transform(frame.position),
        });
    }
    joints
}

/// Nothing to make a body of.
fn nothing_shown(file: &File) -> supple::Error {
    let problem = match file.document.animations.is_empty() {
        true => "the scene shows no triangles",
        false => {
            "the scene shows no triangles: the file is a motion; give it to a character by `supple motion` with --avatar"
        }
    };
    file.broken("meshes", problem)
}

/// The name of a node, or one made up.
pub(super) fn name(file: &File, node: usize) -> String {
    let name = file.document.nodes[node].name.as_ref();
    match name.filter(|n| !n.is_empty()) {
        Some(name) => name.clone(),
        None => format!("node_{node}"),
    }
}

/// Names of bones; those that come again get a number.
fn unique_names(file: &File, nodes: &[usize]) -> Vec<String> {
    let mut taken = BTreeSet::new();
    let unique = |&n: &usize| unique_name(file, n, &mut taken);
    nodes.iter().map(unique).collect()
}

/// The name of a node, with a number where it is taken.
pub(super) fn unique_name(file: &File, node: usize, taken: &mut BTreeSet<String>) -> String {
    let name = name(file, node);
    let numbered = (2..).map(|k| format!("{name}_{k}"));
    let mut candidates = std::iter::once(name.clone()).chain(numbered);
    let free = candidates.find(|c| taken.insert(c.clone()));
    free.unwrap_or(name)
}
