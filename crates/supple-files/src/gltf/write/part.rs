//! A primitive of the skinned mesh: the vertices of one part as the character's file draws them.

use super::buffer::Buffer;
use super::document::floats;
use glam::{DVec3, Vec3};
use serde_json::{Value, json};
use supple::model::{Avatar, RenderMesh, SkinWeight};

/// Displacements shorter than this are left out of a sparse target, m.
const SPARSE_THRESHOLD: f32 = 1e-7;

/// Changes of normals whose components are all smaller are left out.
const NORMAL_THRESHOLD: f32 = 1e-4;

/// A part and the normals of the welded skin.
pub(super) struct Part<'a> {
    pub avatar: &'a Avatar,
    pub part: &'a RenderMesh,
    /// Of each skin vertex, from its triangles.
    pub normals: &'a [DVec3],
}

impl Part<'_> {
    /// Vertices, with texture coordinates up to set `highest`, and triangles.
    pub fn primitive(&self, buffer: &mut Buffer, highest: Option<usize>) -> Value {
        let (part, skin) = (self.part, &self.avatar.skin);
        let positions: Vec<_> = self.of(&skin.position).map(floats).collect();
        let normals: Vec<DVec3> = (0..part.vertices.len()).map(|i| self.normal(i)).collect();
        let floats_of: Vec<_> = normals.iter().map(|n| floats(*n)).collect();
        let mut attributes = json!({
            "POSITION": buffer.floats("VEC3", &positions),
            "NORMAL": buffer.floats("VEC3", &floats_of),
        });
        if !part.tangents.is_empty() {
            let tangents = part.tangents.iter().zip(&normals);
            let tangents: Vec<_> = tangents.map(|(t, n)| unit_tangent(*t, *n)).collect();
            attributes["TANGENT"] = json!(buffer.floats("VEC4", &tangents));
        }
        if !part.colours.is_empty() {
            attributes["COLOR_0"] = json!(buffer.floats("VEC4", &part.colours));
        }
        let own = (!part.texture_coordinates.is_empty()).then_some(0);
        // What a material takes must be there; a file that lacks it is drawn with one point of the texture.
        let none = vec![[0.0; 2]; part.vertices.len()];
        for set in highest.max(own).into_iter().flat_map(|highest| 0..=highest) {
            let coordinates = match set.checked_sub(1) {
                None => Some(&part.texture_coordinates),
                Some(further) => part.further_coordinates.get(further),
            };
            let coordinates = coordinates.filter(|c| !c.is_empty()).unwrap_or(&none);
            let coordinates = buffer.floats("VEC2", coordinates);
            attributes[format!("TEXCOORD_{set}")] = json!(coordinates);
        }
        for set in 0..skin.skinning.longest().div_ceil(4) {
            let rows = part.vertices.iter().map(|&v| skin.skinning.row(v as usize));
            let (bones, weights): (Vec<_>, Vec<_>) = rows.map(|row| influences(row, set)).unzip();
            attributes[format!("JOINTS_{set}")] = json!(buffer.bone_indices(&bones));
            attributes[format!("WEIGHTS_{set}")] = json!(buffer.floats("VEC4", &weights));
        }
        let indices = buffer.triangles(&part.triangles);
        json!({"attributes": attributes, "indices": indices})
    }

    /// A morph target: displacements of skin vertices, and the change of the welded skin's normals.
    pub fn target(&self, buffer: &mut Buffer, moves: &[DVec3], change: &[DVec3]) -> Value {
        let moves: Vec<_> = self.of(moves).map(floats).collect();
        let vertices = self.part.vertices.iter().enumerate();
        let normals: Vec<_> = vertices
            .map(|(i, &v)| floats(self.normal_change(i, change[v as usize])))
            .collect();
        json!({
            "POSITION": buffer.sparse_vectors(&moves, SPARSE_THRESHOLD),
            "NORMAL": buffer.sparse_vectors(&normals, NORMAL_THRESHOLD),
        })
    }

    /// Of skin vertices, those of the part's own.
    fn of<'b, T: Copy>(&'b self, values: &'b [T]) -> impl Iterator<Item = T> + 'b {
        self.part.vertices.iter().map(|&v| values[v as usize])
    }

    /// The file's normal of the part's vertex `i`.
    fn of_file(&self, i: usize) -> Option<DVec3> {
        let normal = Vec3::from_array(*self.part.normals.get(i)?).as_dvec3();
        normal.try_normalize()
    }

    /// The file's normal, or else the welded skin's, or else any.
    fn normal(&self, i: usize) -> DVec3 {
        let welded = self.normals[self.part.vertices[i] as usize];
        (self.of_file(i).or(welded.try_normalize())).unwrap_or(DVec3::Y)
    }

    /// Where the welded skin's normal n changes by δ, it turns by δω = n × δ, and the file's normal m with it: its change
    /// is δω × m.
    fn normal_change(&self, i: usize, change: DVec3) -> DVec3 {
        let welded = self.normals[self.part.vertices[i] as usize];
        match self.of_file(i) {
            Some(normal) => welded.cross(change).cross(normal),
            None => change,
        }
    }
}

/// A tangent of length 1; of one that has no direction, any across the normal.
fn unit_tangent([x, y, z, sign]: [f32; 4], normal: DVec3) -> [f32; 4] {
    let tangent = Vec3::new(x, y, z).as_dvec3();
    let tangent = (tangent.try_normalize()).unwrap_or_else(|| normal.any_orthonormal_vector());
    let [x, y, z] = floats(tangent);
    [x, y, z, if sign < 0.0 { -1.0 } else { 1.0 }]
}

/// The `set`th four bones and weights of a vertex, largest first; absent ones have weight 0.
fn influences(row: &[SkinWeight], set: usize) -> ([u16; 4], [f32; 4]) {
    let mut sorted = row.to_vec();
    sorted.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    let (mut bones, mut weights) = ([0; 4], [0.0; 4]);
    for (k, w) in sorted.iter().skip(4 * set).take(4).enumerate() {
        (bones[k], weights[k]) = (w.bone as u16, w.weight as f32);
    }
    (bones, weights)
}
