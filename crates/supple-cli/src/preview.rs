//! What is in a character file before it is baked.

use super::animations::{Animation, read_animations};
use super::bake_report::attached;
use super::terminal::print_table;
use serde::Serialize;
use std::path::Path;
use supple::Result;
use supple::model::UpAxis;
use supple_bake::{SpringReport, mesh::SkinReport};
use supple_files::{CharacterFile, CharacterFormat, CharacterOptions, read_character};

/// A character file's contents.
#[derive(Serialize)]
pub struct Preview {
    format: CharacterFormat,
    name: String,
    /// Size of the box around the skin, m.
    extent: [f64; 3],
    bones: Vec<String>,
    /// The axis that points up in the file.
    up: UpAxis,
    /// Further names of bones: VRM's humanoid ones.
    aliases: Vec<String>,
    skin: SkinReport,
    closed: bool,
    skin_volume: f64,
    attachments: Vec<Attached>,
    springs: SpringReport,
    drawn_parts: Vec<String>,
    shapes: Vec<String>,
    pose_features: usize,
    animations: Vec<Animation>,
    painted: Vec<String>,
    tets: usize,
    notes: Vec<String>,
}

/// A surface that is not tissue.
#[derive(Serialize)]
struct Attached {
    name: String,
    vertices: usize,
    follows_tissue: bool,
}

impl Preview {
    /// Reads the file at `path`.
    pub fn read(path: &Path) -> Result<Self> {
        let CharacterFile {
            format,
            body,
            shapes,
            mut notes,
            ..
        } = read_character(path, &CharacterOptions::default())?;
        let mut animations = Vec::new();
        if format == CharacterFormat::Gltf {
            let (_, found, about) = read_animations(path)?;
            animations = found;
            notes.extend(about);
        }
        let skin = SkinReport::of(&body.skin)?;
        let (low, high) = body.skin.bounds();
        Ok(Self {
            format,
            up: body.up,
            closed: body.skin.is_closed(),
            skin_volume: body.skin.volume(),
            name: body.name,
            extent: (high - low).to_array(),
            aliases: (body.skeleton.aliases.iter())
                .map(|(alias, bone)| format!("{alias} = {}", body.skeleton.names[*bone as usize]))
                .collect(),
            bones: body.skeleton.names,
            skin,
            springs: SpringReport::of(&body.springs),
            attachments: (body.attachments.into_iter())
                .map(|a| Attached {
                    name: a.name,
                    vertices: a.surface.positions.len(),
                    follows_tissue: a.follows_tissue,
                })
                .collect(),
            drawn_parts: body.render_meshes.into_iter().map(|d| d.name).collect(),
            shapes,
            pose_features: body.pose_blend.features,
            animations,
            painted: body.painted.into_keys().collect(),
            tets: body.layer.mesh.tets.len(),
            notes,
        })
    }

    /// Writes the table.
    pub fn print(&self) {
        let [x, y, z] = self.extent;
        let list = |names: &[String]| match names.len() {
            0 => "none".to_string(),
            n => format!("{n}: {}", names.join(", ")),
        };
        let mut rows = vec![
            ("name", self.name.clone()),
            ("format", format!("{:?}", self.format)),
            ("size", format!("{x:.3} × {y:.3} × {z:.3} m")),
            ("up", format!("{:?}", self.up).to_lowercase()),
            ("bones", list(&self.bones)),
            ("skin", self.skin.to_string()),
            (
                "closed",
                if self.closed {
                    "yes"
                } else {
                    "no: a bake closes it"
                }
                .into(),
            ),
        ];
        if !self.aliases.is_empty() {
            rows.push(("also called", list(&self.aliases)));
        }
        if self.closed {
            rows.push(("encloses", format!("{:.3} l", 1e3 * self.skin_volume)));
        }
        for a in &self.attachments {
            rows.push(("attached", attached(&a.name, a.vertices, a.follows_tissue)));
        }
        if self.springs.joints > 0 {
            rows.push(("spring bones", self.springs.to_string()));
        }
        if !self.drawn_parts.is_empty() {
            rows.push(("drawn parts", list(&self.drawn_parts)));
        }
        rows.push(("shapes", list(&self.shapes)));
        rows.push(("pose columns", self.pose_features.to_string()));
        rows.extend(self.animations.iter().map(Animation::row));
        if !self.painted.is_empty() {
            rows.push(("painted", list(&self.painted)));
        }
        if self.tets > 0 {
            rows.push(("tets", self.tets.to_string()));
        }
        for note in &self.notes {
            rows.push(("note", note.clone()));
        }
        print_table(rows);
    }
}
