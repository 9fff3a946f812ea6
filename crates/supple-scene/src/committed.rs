//! The scenes that come with the program, wherever it runs.

use std::path::{Path, PathBuf};
use supple::internal::write_whole;
use supple::{Error, Result};

macro_rules! files {
    ($($path:literal),* $(,)?) => {
        &[$(($path, include_str!(concat!("../../../assets/", $path)))),*]
    };
}

/// Path below the folder of committed assets, and text.
const FILES: &[(&str, &str)] = files![
    "motions/grasp.jsonl",
    "motions/walk.bvh",
    "scenes/body_spin.toml",
    "scenes/body_walk.toml",
    "scenes/bone_press_m.toml",
    "scenes/bone_press_m_82.toml",
    "scenes/bone_press_s.toml",
    "scenes/chest_press.toml",
    "scenes/compression.toml",
    "scenes/finger_press.toml",
    "scenes/finger_slide.toml",
    "scenes/hand_press.toml",
    "scenes/lift.toml",
    "scenes/limb_cylinders.toml",
    "scenes/palm_cylinders.toml",
    "scenes/posed_contact.toml",
    "scenes/ragdolls.toml",
];

/// Names of all committed scenes, in order.
pub fn committed_scenes() -> impl Iterator<Item = &'static str> {
    (FILES.iter()).filter_map(|(path, _)| path.strip_prefix("scenes/")?.strip_suffix(".toml"))
}

/// Writes the committed scenes, and the motions that they name, below `folder`, and gives the folder of the scenes.
///
/// # Errors
/// [`Error::Io`] where it cannot be written.
pub fn unpack_scenes(folder: &Path) -> Result<PathBuf> {
    for (path, text) in FILES {
        let path = folder.join(path);
        // Not written again where it is there: another process may be reading it.
        if std::fs::read(&path).is_ok_and(|there| there == text.as_bytes()) {
            continue;
        }
        let parent = path.parent().unwrap_or(folder);
        std::fs::create_dir_all(parent).map_err(|e| Error::io(parent, e))?;
        write_whole(&path, text)?;
    }
    Ok(folder.join("scenes"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read_scene;

    #[test]
    fn every_committed_scene_is_embedded_and_reads() {
        let folder = tempfile::tempdir().unwrap();
        let scenes = unpack_scenes(folder.path()).unwrap();
        for name in committed_scenes() {
            let scene = read_scene(scenes.join(name).with_extension("toml")).unwrap();
            let motion = scene.motion.map(|m| m.file);
            assert!(motion.is_none_or(|file| file.exists()), "{name}");
        }
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets");
        for kind in ["scenes", "motions"] {
            for entry in std::fs::read_dir(source.join(kind)).unwrap() {
                let name = entry.unwrap().file_name().into_string().unwrap();
                let path = format!("{kind}/{name}");
                assert!(FILES.iter().any(|f| f.0 == path), "{path}");
            }
        }
    }
}
