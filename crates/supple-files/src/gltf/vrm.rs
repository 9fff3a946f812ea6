//! VRM 0.x and 1.0: humanoid bones of avatars and animations.
//!
//! Both versions rest in a T-pose. A character of version 0.x looks along −z, one of 1.0 along +z as
//! glTF has it.

use super::container::File;
use super::rig::Rig;
use super::told_springs::{index, list};
use serde_json::Value;

/// What the VRM extensions say of the humanoid.
#[derive(Debug, Default)]
pub(super) struct Vrm {
    /// Humanoid names of bones.
    pub humanoid: Vec<(String, u32)>,
    /// Whether the file is of version 0.x.
    pub is_0: bool,
    /// Entries that name what is not there, or no bone moves.
    pub ignored: usize,
}

impl Vrm {
    pub fn read(file: &File, rig: &Rig) -> Self {
        let extensions = &file.document.extensions;
        let mut out = Self {
            is_0: extensions.vrm_1.is_none() && extensions.vrm_0.is_some(),
            ..Self::default()
        };
        for (name, node) in humanoid(file) {
            let bone = node.and_then(|n| rig.bone_of_node.get(n).copied().flatten());
            match bone.filter(|_| out.humanoid.iter().all(|(taken, _)| *taken != name)) {
                Some(bone) => out.humanoid.push((name, bone)),
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
