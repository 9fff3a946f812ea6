//! The animations of a glTF file, and a file that holds nothing else.

use super::terminal::print_table;
use serde::Serialize;
use std::path::Path;
use supple::Result;
use supple_files::{MotionClip, read_gltf_motions};

/// A motion in a file.
#[derive(Serialize)]
pub struct Animation {
    name: String,
    seconds: f64,
    frames: usize,
    bones: usize,
}

impl Animation {
    fn of(clip: MotionClip) -> Self {
        Self {
            seconds: clip.duration(),
            frames: clip.frames.len(),
            bones: clip.bones.len(),
            name: clip.name,
        }
    }

    /// A line of a table.
    pub fn row(&self) -> (&'static str, String) {
        let Self {
            name,
            seconds,
            frames,
            bones,
        } = self;
        let told = format!("{name}: {seconds:.2} s, {frames} frames, {bones} bones");
        ("animation", told)
    }
}

/// The bones of the glTF file's animations, these, and what was decided about them.
pub fn read_animations(path: &Path) -> Result<(Vec<String>, Vec<Animation>, Vec<String>)> {
    let mut clips = read_gltf_motions(path)?;
    let bones = clips
        .first()
        .map_or_else(Vec::new, |clip| clip.bones.clone());
    let notes = clips
        .iter_mut()
        .flat_map(|c| std::mem::take(&mut c.notes))
        .collect();
    Ok((bones, clips.into_iter().map(Animation::of).collect(), notes))
}

/// The contents of a file that moves a body and shows none.
#[derive(Serialize)]
pub struct MotionPreview {
    bones: Vec<String>,
    animations: Vec<Animation>,
    notes: Vec<String>,
}

impl MotionPreview {
    /// Reads the file at `path`.
    pub fn read(path: &Path) -> Result<Self> {
        let (bones, animations, notes) = read_animations(path)?;
        Ok(Self {
            bones,
            animations,
            notes,
        })
    }

    /// Writes the table.
    pub fn print(&self) {
        let bones = format!("{}: {}", self.bones.len(), self.bones.join(", "));
        let notes = self.notes.iter().map(|note| ("note", note.clone()));
        let animations = self.animations.iter().map(Animation::row);
        print_table(
            std::iter::once(("bones", bones))
                .chain(animations)
                .chain(notes),
        );
    }
}
