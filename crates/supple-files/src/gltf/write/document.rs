//! The glTF document: nodes, materials, animation.

use super::buffer::{Buffer, container};
use super::materials::Materials;
use super::morph::{MOST_MORPHS, Morphs};
use super::{Prop, Recording};
use crate::{BODY_COLOUR, from_srgb, solid_surface};
use glam::{DQuat, DVec3};
use serde_json::{Value, json};
use std::path::Path;
use supple::Result;
use supple::internal::write_whole;
use supple::model::{Avatar, Frame, JointBone, RigidBody, Surface, UpAxis};

/// What was written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GlbReport {
    /// Size of the file.
    pub bytes: usize,
    /// Number of morph targets.
    pub morphs: usize,
    /// Whether the morphs are the handles' own axes (and play anything), or a basis of this motion.
    pub per_handle: bool,
    /// Largest unposed displacement that the morphs miss at any vertex and recorded state, m.
    pub largest_morph_error: f64,
    /// Most bones of a vertex; viewers that read four drop the rest.
    pub influences: usize,
    /// Images of the character's file that are in it.
    pub images: usize,
}

/// How a GLB file is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GlbOptions {
    /// Most morph targets. Each costs a viewer memory and time, and some take no more than 64.
    pub most_morphs: usize,
}

impl Default for GlbOptions {
    fn default() -> Self {
        Self {
            most_morphs: MOST_MORPHS,
        }
    }
}

/// Writes `recording` as a GLB file with a skin, [`MOST_MORPHS`] morph targets at most, one animation, and the materials and
/// images of the character's file, as far as the avatar has them.
///
/// # Errors
/// [`supple::Error::Invalid`] where the recording is not this avatar's, or its appearance is no JSON; [`supple::Error::Io`].
pub fn write_glb(
    avatar: &Avatar,
    recording: &Recording,
    path: impl AsRef<Path>,
) -> Result<GlbReport> {
    write_glb_with(avatar, recording, GlbOptions::default(), path)
}

/// [`write_glb`] with other `options`.
///
/// # Errors
/// As [`write_glb`].
pub fn write_glb_with(
    avatar: &Avatar,
    recording: &Recording,
    options: GlbOptions,
    path: impl AsRef<Path>,
) -> Result<GlbReport> {
    recording.validate(avatar)?;
    let morphs = Morphs::new(avatar, recording, options.most_morphs)?;
    let mut file = Document::new(Materials::new(&avatar.appearance)?);
    let times = as_floats(&recording.times);
    file.times = file.buffer.floats("SCALAR", &times);
    let upright = DQuat::from_mat3(&recording.up.rotation_to(UpAxis::Y));
    let world = file.node(json!({
        "name": "world", "rotation": quaternion(upright).to_vec(), "children": [],
    }));
    let bones = file.skeleton(avatar, recording, world);
    file.riding_joints(avatar, &bones);
    file.skin(avatar, &morphs, &bones);
    for (body, node) in avatar.bodies.iter().zip(&bones[avatar.bones()..]) {
        file.body(body, *node);
    }
    for prop in &recording.props {
        file.prop(prop, world);
    }
    let images = file.materials.images.len();
    let bytes = file.finish(&avatar.name)?;
    write_whole(path, &bytes)?;
    Ok(GlbReport {
        bytes: bytes.len(),
        morphs: morphs.targets.len(),
        per_handle: morphs.per_handle,
        largest_morph_error: morphs.largest_error,
        influences: avatar.skin.skinning.longest(),
        images,
    })
}

pub(super) struct Document<'a> {
    pub buffer: Buffer,
    nodes: Vec<Value>,
    /// Nodes of the scene itself.
    roots: Vec<usize>,
    pub meshes: Vec<Value>,
    pub skins: Vec<Value>,
    pub materials: Materials<'a>,
    samplers: Vec<Value>,
    channels: Vec<Value>,
    /// Accessor of the key times.
    times: usize,
}

impl<'a> Document<'a> {
    fn new(materials: Materials<'a>) -> Self {
        Self {
            buffer: Buffer::default(),
            nodes: Vec::new(),
            roots: Vec::new(),
            meshes: Vec::new(),
            skins: Vec::new(),
            materials,
            samplers: Vec::new(),
            channels: Vec::new(),
            times: 0,
        }
    }

    /// A node of the scene.
    pub fn node(&mut self, node: Value) -> usize {
        self.nodes.push(node);
        self.roots.push(self.nodes.len() - 1);
        self.nodes.len() - 1
    }

    /// A node under another one.
    fn child(&mut self, parent: usize, node: Value) -> usize {
        self.nodes.push(node);
        let index = self.nodes.len() - 1;
        match self.nodes[parent]["children"].as_array_mut() {
            Some(children) => children.push(json!(index)),
            None => self.nodes[parent]["children"] = json!([index]),
        }
        index
    }

    /// Animates a property of a node at the key times.
    pub fn animate(&mut self, node: usize, path: &str, output: usize) {
        self.samplers
            .push(json!({"input": self.times, "output": output, "interpolation": "LINEAR"}));
        self.channels.push(json!({
            "sampler": self.samplers.len() - 1, "target": {"node": node, "path": path},
        }));
    }

    /// Animates a rigid node by its frames.
    fn animate_frames(&mut self, node: usize, frames: &[Frame]) {
        let mut rotations: Vec<[f32; 4]> = Vec::with_capacity(frames.len());
        for frame in frames {
            let q = quaternion(DQuat::from_mat3(&frame.rotation).normalize());
            // q and −q are one rotation: keep to the side of the key before, as players interpolate.
            let away = rotations
                .last()
                .is_some_and(|last| last.iter().zip(q).map(|(a, b)| a * b).sum::<f32>() < 0.0);
            rotations.push(if away { q.map(|c| -c) } else { q });
        }
        let positions: Vec<_> = frames.iter().map(|f| floats(f.position)).collect();
        let rotations = self.buffer.floats("VEC4", &rotations);
        self.animate(node, "rotation", rotations);
        let positions = self.buffer.floats("VEC3", &positions);
        self.animate(node, "translation", positions);
    }

    /// A node for each joint that rides on a bone, where the bone has it. Like those of bones they have the axes of the
    /// reference shape.
    fn riding_joints(&mut self, avatar: &Avatar, bones: &[usize]) {
        for joint in avatar.joints.joints() {
            if let JointBone::RidesOn(bone) = joint.bone {
                let place = floats(joint.bind.translation).to_vec();
                let node = json!({"name": joint.name, "translation": place});
                self.child(bones[bone as usize], node);
            }
        }
    }

    /// A node for each bone, animated relative to its parent.
    fn skeleton(&mut self, avatar: &Avatar, recording: &Recording, world: usize) -> Vec<usize> {
        let skeleton = &avatar.skeleton;
        let mut bones: Vec<usize> = Vec::new();
        for (j, name) in skeleton.names.iter().enumerate() {
            let parent = skeleton.parents[j].map(|p| p as usize);
            let rest = skeleton.joints[j] - parent.map_or(DVec3::ZERO, |p| skeleton.joints[p]);
            let node = json!({"name": name, "translation": floats(rest).to_vec()});
            let node = self.child(parent.map_or(world, |p| bones[p]), node);
            bones.push(node);
            let local = |frames: &[Frame]| match parent {
                None => frames[j],
                Some(p) => Frame {
                    rotation: frames[p].rotation.transpose() * frames[j].rotation,
                    position: frames[p].inverse_transform(frames[j].position),
                },
            };
            let frames: Vec<_> = recording.states.iter().map(|s| local(&s.frames)).collect();
            self.animate_frames(node, &frames);
        }
        bones
    }

    /// The mesh of a body, carried by its bone's `node`.
    fn body(&mut self, body: &RigidBody, node: usize) {
        let surface = solid_surface(&body.shape, 0.0);
        let primitive = self.primitive(&surface, from_srgb(BODY_COLOUR), 0.6);
        let name = format!("{} surface", body.name);
        (self.meshes).push(json!({"name": name, "primitives": [primitive]}));
        self.child(node, json!({"name": name, "mesh": self.meshes.len() - 1}));
    }

    /// A rigid mesh; it is animated only if it moves.
    fn prop(&mut self, prop: &Prop, world: usize) {
        let primitive = self.primitive(&prop.surface, prop.colour, 0.8);
        self.meshes
            .push(json!({"name": prop.name, "primitives": [primitive]}));
        let mut node = json!({"name": prop.name, "mesh": self.meshes.len() - 1});
        let first = prop.frames.first().copied().unwrap_or(Frame::IDENTITY);
        let rotation = DQuat::from_mat3(&first.rotation).normalize();
        node["rotation"] = json!(quaternion(rotation).to_vec());
        node["translation"] = json!(floats(first.position).to_vec());
        let node = self.child(world, node);
        if prop.frames.iter().any(|f| *f != first) {
            self.animate_frames(node, &prop.frames);
        }
    }

    /// A triangle primitive with its own material.
    fn primitive(&mut self, surface: &Surface, colour: [f32; 3], roughness: f32) -> Value {
        let positions: Vec<_> = surface.positions.iter().map(|p| floats(*p)).collect();
        let normals: Vec<_> = surface.vertex_normals().into_iter().map(floats).collect();
        json!({
            "attributes": {
                "POSITION": self.buffer.floats("VEC3", &positions),
                "NORMAL": self.buffer.floats("VEC3", &normals),
            },
            "indices": self.buffer.triangles(&surface.triangles),
            "material": self.material("", colour, roughness),
        })
    }

    /// A plain material; without a name where that is empty.
    pub fn material(&mut self, name: &str, [r, g, b]: [f32; 3], roughness: f32) -> usize {
        let mut material = json!({"pbrMetallicRoughness": {
            "baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": roughness,
        }});
        if !name.is_empty() {
            material["name"] = json!(name);
        }
        self.materials.plain(material)
    }

    fn finish(self, name: &str) -> Result<Vec<u8>> {
        let mut document = json!({
            "asset": {"version": "2.0", "generator": concat!("supple ", env!("CARGO_PKG_VERSION"))},
            "scene": 0,
            "scenes": [{"nodes": self.roots}],
            "nodes": self.nodes,
            "buffers": [{"byteLength": self.buffer.bytes.len()}],
        });
        let (used, required) = self.materials.extensions();
        document["animations"] =
            json!([{"name": name, "samplers": self.samplers, "channels": self.channels}]);
        // Of what there is none, glTF has no list.
        for (key, list) in [
            ("extensionsUsed", json!(used)),
            ("extensionsRequired", json!(required)),
            ("meshes", json!(self.meshes)),
            ("materials", json!(self.materials.to.materials)),
            ("textures", json!(self.materials.to.textures)),
            ("samplers", json!(self.materials.to.samplers)),
            ("images", json!(self.materials.images)),
            ("skins", json!(self.skins)),
            ("accessors", json!(self.buffer.accessors)),
            ("bufferViews", json!(self.buffer.views)),
        ] {
            if list.as_array().is_some_and(|list| !list.is_empty()) {
                document[key] = list;
            }
        }
        container(&document, &self.buffer.bytes)
    }
}

pub(super) fn as_floats(values: &[f64]) -> Vec<[f32; 1]> {
    values.iter().map(|v| [*v as f32]).collect()
}

pub(super) fn floats(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

fn quaternion(q: DQuat) -> [f32; 4] {
    q.as_quat().normalize().to_array()
}
