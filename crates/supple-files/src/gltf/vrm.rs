//! VRM 0.x and 1.0: humanoid bones of avatars and animations, and the colliders of spring bones.
//!
//! Both versions rest in a T-pose. A character of version 0.x looks along −z, one of 1.0 along +z as
//! glTF has it.

use super::container::File;
use super::nodes::Nodes;
use super::polar::scale;
use super::rig::Rig;
use glam::DVec3;
use serde_json::Value;

/// A sphere or capsule that a file fixes to a bone, about as large as the body there.
#[derive(Clone, Debug, PartialEq)]
pub struct BoneCollider {
    /// Name or number of the collider group that it is in; empty where it is in none.
    pub group: String,
    /// The bone.
    pub bone: u32,
    /// Middle of the sphere, or of the capsule's first end: from the bone's joint, in the axes of the
    /// reference shape, m.
    pub offset: DVec3,
    /// Middle of the capsule's other end; nothing for a sphere.
    pub tail: Option<DVec3>,
    /// Radius, m.
    pub radius: f64,
}

/// What the VRM extensions say.
#[derive(Debug, Default)]
pub(super) struct Vrm {
    /// Humanoid names of bones.
    pub humanoid: Vec<(String, u32)>,
    pub colliders: Vec<BoneCollider>,
    /// Whether the file is of version 0.x.
    pub is_0: bool,
    /// Entries that name what is not there, or no bone moves.
    pub ignored: usize,
}

/// A collider as a file has it: group, node, middles, radius, all in the node's own coordinates.
struct Found {
    group: String,
    node: usize,
    offset: DVec3,
    tail: Option<DVec3>,
    radius: f64,
}

impl Vrm {
    pub fn read(file: &File, nodes: &Nodes, rig: &Rig) -> Self {
        let mut out = Self::default();
        let extensions = &file.document.extensions;
        let mut found: Vec<Option<Found>> = Vec::new();
        if let (None, Some(vrm)) = (&extensions.vrm_1, &extensions.vrm_0) {
            out.is_0 = true;
            found = colliders_0(vrm);
        }
        if let Some(springs) = &extensions.spring_bones {
            found.extend(colliders_1(springs));
        }
        for (name, node) in humanoid(file) {
            let bone = node.and_then(|n| rig.bone_of_node.get(n).copied().flatten());
            match bone.filter(|_| out.humanoid.iter().all(|(taken, _)| *taken != name)) {
                Some(bone) => out.humanoid.push((name, bone)),
                None => out.ignored += 1,
            }
        }
        for found in found {
            match found.and_then(|f| f.on_bone(nodes, rig)) {
                Some(collider) => out.colliders.push(collider),
                None => out.ignored += 1,
            }
        }
        out
    }
}

/// Names of an avatar's humanoid bones, and their nodes as the file has them.
pub(super) fn humanoid(file: &File) -> Vec<(String, Option<usize>)> {
    let extensions = &file.document.extensions;
    match (&extensions.vrm_1, &extensions.vrm_0) {
        (Some(vrm), _) => humanoid_1(vrm),
        (None, Some(vrm)) => {
            // [{"bone": "hips", "node": 3}, …]
            let bones = list(&vrm["humanoid"]["humanBones"]).iter();
            let named = |b: &Value| Some((b["bone"].as_str()?.to_string(), index(&b["node"])));
            bones.filter_map(named).collect()
        }
        (None, None) => Vec::new(),
    }
}

/// The same of a VRM animation (`.vrma`), which has nothing but those to move a body.
pub(super) fn animated_humanoid(file: &File) -> Vec<(String, Option<usize>)> {
    let extension = file.document.extensions.vrm_animation.as_ref();
    extension.map_or_else(Vec::new, humanoid_1)
}

/// `{"hips": {"node": 3}, …}`, of version 1.0 and of animations.
fn humanoid_1(extension: &Value) -> Vec<(String, Option<usize>)> {
    let bones = extension["humanoid"]["humanBones"].as_object();
    (bones.into_iter().flatten())
        .map(|(name, bone)| (name.clone(), index(&bone["node"])))
        .collect()
}

impl Found {
    fn on_bone(self, nodes: &Nodes, rig: &Rig) -> Option<BoneCollider> {
        let world = nodes.rest_world.get(self.node)?;
        let bone = rig.bone_above(nodes, self.node)?;
        let frame = &rig.rest[bone as usize];
        let place = |p: DVec3| frame.inverse_transform(world.transform_point3(p));
        let collider = BoneCollider {
            group: self.group,
            bone,
            offset: place(self.offset),
            tail: self.tail.map(place),
            radius: scale(world.matrix3) * self.radius,
        };
        let finite = collider.offset.is_finite()
            && collider.tail.is_none_or(|t| t.is_finite())
            && collider.radius.is_finite();
        (finite && collider.radius > 0.0).then_some(collider)
    }
}

/// `secondaryAnimation.colliderGroups` of VRM 0.x: spheres. Their z points the other way than glTF's.
fn colliders_0(vrm: &Value) -> Vec<Option<Found>> {
    let groups = list(&vrm["secondaryAnimation"]["colliderGroups"]).iter();
    let of_group = |(k, group): (usize, &Value)| {
        let sphere = |c: &Value| {
            let axis = |name: &str| c["offset"][name].as_f64().unwrap_or(0.0);
            Some(Found {
                group: k.to_string(),
                node: index(&group["node"])?,
                offset: DVec3::new(axis("x"), axis("y"), -axis("z")),
                tail: None,
                radius: c["radius"].as_f64()?,
            })
        };
        list(&group["colliders"])
            .iter()
            .map(sphere)
            .collect::<Vec<_>>()
    };
    groups.enumerate().flat_map(of_group).collect()
}

/// `colliders` of VRMC_springBone, with the first of the `colliderGroups` that each is in.
fn colliders_1(springs: &Value) -> Vec<Option<Found>> {
    let groups = list(&springs["colliderGroups"]);
    let group_of = |collider: usize| {
        let holds = |g: &Value| {
            list(&g["colliders"])
                .iter()
                .any(|c| index(c) == Some(collider))
        };
        let k = groups.iter().position(holds)?;
        Some(
            groups[k]["name"]
                .as_str()
                .map_or_else(|| k.to_string(), String::from),
        )
    };
    let vector = |v: &Value| {
        let axis = |k: usize| v[k].as_f64().unwrap_or(0.0);
        DVec3::new(axis(0), axis(1), axis(2))
    };
    let read = |(k, c): (usize, &Value)| {
        let (sphere, capsule) = (&c["shape"]["sphere"], &c["shape"]["capsule"]);
        let shape = if sphere.is_object() { sphere } else { capsule };
        Some(Found {
            group: group_of(k).unwrap_or_default(),
            node: index(&c["node"])?,
            offset: vector(&shape["offset"]),
            tail: capsule.is_object().then(|| vector(&capsule["tail"])),
            radius: shape["radius"].as_f64()?,
        })
    };
    list(&springs["colliders"])
        .iter()
        .enumerate()
        .map(read)
        .collect()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn index(value: &Value) -> Option<usize> {
    usize::try_from(value.as_u64()?).ok()
}
