//! What is to be shown.

use std::path::{Path, PathBuf};
use supple::Result;
use supple_files::{is_gltf_motion, read_amass};
use supple_samples::Sample;
use supple_scene::{AvatarSource, Scene, avatar_source_of, read_scene};

/// What is to be shown.
#[derive(Clone, Debug, PartialEq)]
pub enum Request {
    /// A body that the program makes itself.
    Sample(Sample),
    /// Any file: a character, a baked avatar, a recipe, a scene.
    File(PathBuf),
    /// A scene, with another avatar than its own if one is given.
    Scene {
        /// Its file.
        scene: PathBuf,
        /// In place of its own avatar.
        avatar: Option<PathBuf>,
    },
    /// Any of these with another motion.
    Moved {
        /// Who.
        who: Box<Self>,
        /// A motion of any kind that scenes read.
        motion: PathBuf,
    },
}

impl Request {
    /// What it is called before it is read.
    pub fn name(&self) -> String {
        let stem = |path: &PathBuf| {
            path.file_stem()
                .unwrap_or_default()
                .to_string_lossy()
                .into()
        };
        match self {
            Self::Sample(sample) => {
                let key = serde_json::to_value(sample).unwrap_or_default();
                key.as_str().unwrap_or("sample").into()
            }
            Self::File(path) => stem(path),
            Self::Scene { scene, avatar } => stem(avatar.as_ref().unwrap_or(scene)),
            Self::Moved { who, .. } => who.name(),
        }
    }

    /// The same with the motion in a file, in place of any before.
    pub fn with_motion(self, motion: PathBuf) -> Self {
        let who = match self {
            Self::Moved { who, .. } => who,
            other => Box::new(other),
        };
        Self::Moved { who, motion }
    }

    /// The motion that is asked for in place of the character's own.
    pub(super) fn motion(&self) -> Option<&PathBuf> {
        match self {
            Self::Moved { motion, .. } => Some(motion),
            _ => None,
        }
    }

    /// Who it is about, and the scene that somebody wrote, if there is one.
    pub(super) fn source(&self) -> Result<(AvatarSource, Option<Scene>)> {
        match self {
            Self::Sample(sample) => Ok((AvatarSource::of_sample(*sample), None)),
            Self::File(path) => {
                let source = avatar_source_of(path)?;
                // A scene is a file of the same kind as a recipe.
                let scene = path
                    .extension()
                    .is_some_and(|e| e == "toml")
                    .then(|| read_scene(path));
                Ok((source, scene.and_then(Result::ok)))
            }
            Self::Scene { scene, avatar } => {
                let mut scene = read_scene(scene)?;
                if let Some(path) = avatar {
                    scene.avatar = avatar_source_of(path)?;
                }
                Ok((scene.avatar.clone(), Some(scene)))
            }
            // Another motion is for who does nothing else.
            Self::Moved { who, .. } => Ok((who.source()?.0, None)),
        }
    }
}

/// Whether the file at `path` is a motion, and no character.
pub fn is_motion(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    match extension.to_lowercase().as_str() {
        "bvh" | "vrma" | "jsonl" | "ndjson" | "js" | "json" => true,
        "npz" => read_amass(path).is_ok(),
        "glb" | "gltf" => is_gltf_motion(path).is_ok_and(|motion| motion),
        _ => false,
    }
}
