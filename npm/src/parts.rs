//! How the character's file draws the skin.

use crate::avatar::Core;
use serde::Serialize;
use supple::model::Avatar;
use wasm_bindgen::prelude::*;

/// What is to be known of a drawn part, besides its arrays.
#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct PartInfo<'a> {
    name: &'a str,
    material: &'a str,
    material_index: Option<u32>,
    /// Its first vertex among those of all parts, and how many it has.
    first: usize,
    vertices: usize,
    /// Whether any of it is tissue or hangs on tissue, so that it moves in itself.
    soft: bool,
    /// Sets of texture coordinates.
    coordinates: usize,
}

#[wasm_bindgen]
impl Core {
    /// The drawn parts, as JSON.
    pub fn parts(&self) -> String {
        let avatar = &self.avatar;
        let mut first = 0;
        let parts = avatar.render_meshes.iter().map(|part| {
            let coordinates = usize::from(!part.texture_coordinates.is_empty());
            let info = PartInfo {
                name: &part.name,
                material: &part.material,
                material_index: part.material_index,
                first,
                vertices: part.vertices.len(),
                soft: part.vertices.iter().any(|&v| is_soft(avatar, v as usize)),
                coordinates: coordinates + part.further_coordinates.len(),
            };
            first += part.vertices.len();
            info
        });
        let parts: Vec<PartInfo<'_>> = parts.collect();
        serde_json::to_string(&parts).unwrap_or_default()
    }

    /// Triangles of a part's own vertices.
    pub fn part_triangles(&self, part: usize) -> Option<Vec<u32>> {
        let part = self.avatar.render_meshes.get(part)?;
        Some(part.triangles.as_flattened().to_vec())
    }

    /// The skin vertex that each of a part's own vertices is.
    pub fn part_vertices(&self, part: usize) -> Option<Vec<u32>> {
        Some(self.avatar.render_meshes.get(part)?.vertices.clone())
    }

    /// A set of a part's texture coordinates.
    pub fn part_coordinates(&self, part: usize, set: usize) -> Option<Vec<f32>> {
        let part = self.avatar.render_meshes.get(part)?;
        let coordinates = match set {
            0 => &part.texture_coordinates,
            _ => part.further_coordinates.get(set - 1)?,
        };
        Some(coordinates.as_flattened().to_vec())
    }

    /// A part's colours, red, green, blue and opacity; none where it has none.
    pub fn part_colours(&self, part: usize) -> Option<Vec<f32>> {
        let colours = &self.avatar.render_meshes.get(part)?.colours;
        (!colours.is_empty()).then(|| colours.as_flattened().to_vec())
    }
}

/// Whether a skin vertex is tissue's or follows some.
fn is_soft(avatar: &Avatar, vertex: usize) -> bool {
    match vertex.checked_sub(avatar.tissue_vertices()) {
        None => true,
        Some(attached) => {
            (attached < avatar.attached.len()) && !avatar.attached.row(attached).is_empty()
        }
    }
}
