//! One skeleton out of a file's skins, and the reference shape that goes with it.
//!
//! glTF poses a vertex v of skin s at Σ_j w_j M_j v with M_j = world_j · inverseBind_{s,j}. This crate's
//! bones are rigid: x = Σ_j w_j (R_j (X − J_j) + c_j). So that both are one:
//!
//! - c_j is where node j stands;
//! - R_j is the rotation of M_j G⁻¹, G being M of the skin's reference bone: whatever placement, unit and
//!   axes the file binds in (G) becomes part of X, which is in the scene's coordinates, upright and in m;
//! - J_j follows from R and c at rest by the bones' tree: J_j = J_p + R_pᵀ (c_j − c_p);
//! - X is the vertex at rest with the bones' own transformation undone:
//!   X = B⁻¹ (Σ w_j M_j v − Σ w_j (c_j − R_j J_j)), B = Σ w_j R_j.
//!
//! The rest pose is so met exactly, for whatever skins share bones. Where the file's bind pose and rest
//! pose differ by rotations of bones alone, as they should, so is every other pose, and X = G v.

use super::bone_tree::BoneTree;
use super::container::File;
use super::nodes::{Nodes, similarity};
use super::primitive::Part;
use glam::{DAffine3, DMat3, DMat4, DVec3};
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
    pub skins: BTreeMap<usize, BoundSkin>,
    /// The skins, that of most vertices first.
    pub largest_first: Vec<usize>,
}

/// A skin whose joints are bones.
#[derive(Debug)]
pub(super) struct BoundSkin {
    /// Bone of each joint.
    pub bones: Vec<u32>,
    /// Of each joint.
    pub inverse_binds: Vec<DAffine3>,
    /// M_j at rest, of each joint.
    pub skinning: Vec<DAffine3>,
    /// G: what takes the mesh to the reference shape, if it is the same for all joints.
    pub reference: DAffine3,
}

impl Rig {
    /// The rig of the skins that `parts` use; of a file without skins, one bone.
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
        let bind = order
            .iter()
            .map(|&s| Ok((s, inverse_bind_matrices(file, s)?)));
        let bind: BTreeMap<usize, Vec<DAffine3>> = bind.collect::<Result<_>>()?;
        let joints = |s: &usize| &file.document.skins[*s].joints;

        let is_joint: BTreeSet<usize> = order.iter().flat_map(joints).copied().collect();
        if let Some(joint) = is_joint.iter().find(|&&j| j >= nodes.parents.len()) {
            return Err(file.broken("skins", format!("joint {joint} is no node")));
        }

        let mut weight = vec![0.0; nodes.parents.len()];
        for part in parts.iter().filter(|p| p.skin.is_some()) {
            let joints = part.skin.map(|s| joints(&s));
            for &(joint, w) in part.influences.entries() {
                weight[joints.map_or(0, |j| j[joint as usize])] += w;
            }
        }
        if is_joint.len() > MOST_JOINTS {
            let problem = format!("{} joints; {MOST_JOINTS} at most are read", is_joint.len());
            return Err(file.broken("skins", problem));
        }
        let tree = BoneTree::new(file, nodes, &is_joint, &weight);
        let Some(tree) = tree else {
            return one_bone(file, nodes, parts);
        };
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
        for &n in &tree.nodes {
            let world = nodes.rest_world[n].matrix3;
            similarity(world).map_err(|problem| {
                let problem = format!("bone {} {problem}: apply its scale", name(file, n));
                file.broken(format!("nodes[{n}]"), problem)
            })?;
        }

        let mut rotation: Vec<Option<DMat3>> = vec![None; tree.nodes.len()];
        let mut skins: BTreeMap<usize, BoundSkin> = BTreeMap::new();
        for &s in &order {
            let bones: Vec<u32> = (joints(&s).iter().filter_map(|&n| bone_of_node[n])).collect();
            let place = |(&n, bind): (&usize, &DAffine3)| nodes.rest_world[n] * *bind;
            let skinning: Vec<DAffine3> = joints(&s).iter().zip(&bind[&s]).map(place).collect();
            // The bone nearest to the root that another skin has placed, or else that has weight.
            let best = (0..bones.len()).min_by_key(|&k| {
                let bone = bones[k] as usize;
                let weighted = weight[tree.nodes[bone]] > 0.0;
                (rotation[bone].is_none(), !weighted, bone)
            });
            let Some(best) = best else { continue };
            let known = rotation[bones[best] as usize].unwrap_or(DMat3::IDENTITY);
            let linear = known.transpose() * skinning[best].matrix3;
            for (k, &bone) in bones.iter().enumerate() {
                if rotation[bone as usize].is_none() {
                    let relative = similarity(skinning[k].matrix3 * linear.inverse());
                    let n = tree.nodes[bone as usize];
                    let found = relative.map_err(|problem| {
                        let problem = format!(
                            "its inverse bind matrix of joint {} {problem}",
                            name(file, n)
                        );
                        file.broken(format!("skins[{s}]"), problem)
                    })?;
                    rotation[bone as usize] = Some(found.rotation);
                }
            }
            let bound = BoundSkin {
                bones,
                inverse_binds: bind[&s].clone(),
                skinning,
                reference: DAffine3::from_mat3(linear),
            };
            skins.insert(s, bound);
        }

        let rest: Vec<Frame> = (tree.nodes.iter().zip(&rotation))
            .map(|(&n, rotation)| Frame {
                rotation: rotation.unwrap_or(DMat3::IDENTITY),
                position: nodes.rest_world[n].translation,
            })
            .collect();
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
            skins,
            largest_first: order,
        };
        rig.anchor(&weight);
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
    fn anchor(&mut self, weight: &[f64]) {
        let first = self
            .nodes
            .iter()
            .position(|&n| weight[n] > 0.0)
            .unwrap_or(0);
        let shift = self.rest[first].position - self.skeleton.joints[first];
        (self.skeleton.joints.iter_mut()).for_each(|j| *j += shift);
    }

    /// The bone that moves what hangs on `node`: its own, or the nearest above.
    pub fn bone_above(&self, nodes: &Nodes, node: usize) -> Option<u32> {
        let mut up = nodes.upward(node);
        match self.skins.is_empty() {
            true => Some(0),
            false => up.find_map(|n| self.bone_of_node[n]),
        }
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

/// A file without a skin is one rigid bone where its first mesh stands.
fn one_bone(file: &File, nodes: &Nodes, parts: &[Part]) -> Result<Rig> {
    let Some(part) = parts.first() else {
        return Err(file.broken("meshes", "the scene shows no triangles"));
    };
    let rest = Frame {
        rotation: DMat3::IDENTITY,
        position: nodes.rest_world[part.node].translation,
    };
    let mut bone_of_node = vec![None; nodes.parents.len()];
    bone_of_node[part.node] = Some(0);
    Ok(Rig {
        skeleton: Skeleton {
            names: unique_names(file, &[part.node]),
            parents: vec![None],
            joints: vec![rest.position],
            aliases: Vec::new(),
            limits: Vec::new(),
        },
        nodes: vec![part.node],
        bone_of_node,
        rest: vec![rest],
        skins: BTreeMap::new(),
        largest_first: Vec::new(),
    })
}

/// The inverse bind matrices of a skin, the identity where there are none.
fn inverse_bind_matrices(file: &File, skin: usize) -> Result<Vec<DAffine3>> {
    let field = || format!("skins[{skin}].inverseBindMatrices");
    let found = &file.document.skins[skin];
    let Some(accessor) = found.inverse_bind_matrices else {
        return Ok(vec![DAffine3::IDENTITY; found.joints.len()]);
    };
    let matrices = file.vectors::<16>(accessor)?;
    if matrices.len() < found.joints.len() {
        let problem = format!("{} for {} joints", matrices.len(), found.joints.len());
        return Err(file.broken(field(), problem));
    }
    let affine = |m: &[f64; 16]| {
        let m = DMat4::from_cols_array(m);
        let last = (m.row(3) - glam::DVec4::W).abs().max_element();
        let sound = last < 1e-6 && m.determinant().abs() > 1e-30;
        sound.then(|| DAffine3::from_mat4(m)).ok_or_else(|| {
            file.broken(
                field(),
                "one has no inverse, or a last row that is not 0 0 0 1",
            )
        })
    };
    matrices
        .iter()
        .take(found.joints.len())
        .map(affine)
        .collect()
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
