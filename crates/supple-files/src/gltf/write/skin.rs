//! The skinned mesh: a primitive for each part that the body's file draws, or one of the whole skin.
//!
//! Parts keep what their file draws them with: vertices split along seams, normals, tangents, colours, texture
//! coordinates, materials. Normals turn with the welded skin's.

use super::document::{Document, as_floats};
use super::morph::Morphs;
use super::normals::normal_change;
use super::part::Part;
use crate::gltf::appearance::coordinate_sets;
use crate::gltf::appearance::for_textures;
use glam::{DMat4, DVec3};
use serde_json::{Value, json};
use supple::model::{Avatar, RenderMesh, Surface};

const SKIN: [f32; 3] = [0.80, 0.52, 0.41];
/// Of what is attached to the skin.
const ATTACHED: [f32; 3] = [0.45, 0.47, 0.52];
/// Of what has colours at its vertices.
const WHITE: [f32; 3] = [1.0; 3];

impl Document<'_> {
    /// The skinned mesh of an avatar.
    pub fn skin(&mut self, avatar: &Avatar, morphs: &Morphs, bones: &[usize]) {
        let surface = Surface {
            positions: avatar.skin.position.clone(),
            triangles: avatar.triangles.clone(),
        };
        let normals = of_followed(avatar, surface.vertex_normals());
        // Each target's displacement of positions and of normals.
        let targets: Vec<(&[DVec3], Vec<DVec3>)> = (morphs.targets.iter())
            .map(|target| {
                let change = normal_change(&surface, target);
                (target.as_slice(), of_followed(avatar, change))
            })
            .collect();
        let whole;
        let parts = match avatar.render_meshes.as_slice() {
            [] => {
                whole = [whole_skin(avatar)];
                &whole
            }
            parts => parts,
        };
        let mut primitives: Vec<Value> = Vec::new();
        // A primitive must draw something.
        for part in parts.iter().filter(|p| !p.triangles.is_empty()) {
            let material = self.material_of(avatar, part);
            let highest = highest_set(&self.materials.to.materials[material]);
            let part = Part {
                avatar,
                part,
                normals: &normals,
            };
            let mut primitive = part.primitive(&mut self.buffer, highest);
            primitive["material"] = json!(material);
            if !targets.is_empty() {
                let targets = (targets.iter())
                    .map(|(moves, change)| part.target(&mut self.buffer, moves, change));
                primitive["targets"] = targets.collect();
            }
            primitives.push(primitive);
        }
        let mut mesh = json!({"name": avatar.name, "primitives": primitives});
        if !targets.is_empty() {
            let rest = morphs.weights[0].iter().map(|w| *w as f32);
            mesh["weights"] = json!(rest.collect::<Vec<_>>());
            mesh["extras"] = json!({"targetNames": morphs.names});
        }
        self.meshes.push(mesh);
        let bind = |j: &DVec3| {
            DMat4::from_translation(-*j)
                .to_cols_array()
                .map(|v| v as f32)
        };
        let bind: Vec<[f32; 16]> = avatar.skeleton.joints.iter().map(bind).collect();
        let matrices = self.buffer.floats("MAT4", &bind);
        self.skins
            .push(json!({"inverseBindMatrices": matrices, "joints": bones}));
        // The node of a skinned mesh stands in the scene itself: its own placement is ignored.
        let node = json!({
            "name": avatar.name, "mesh": self.meshes.len() - 1, "skin": self.skins.len() - 1,
        });
        let node = self.node(node);
        if !targets.is_empty() {
            let weights = as_floats(&morphs.weights.concat());
            let weights = self.buffer.floats("SCALAR", &weights);
            self.animate(node, "weights", weights);
        }
    }

    /// The material of a part: its file's, or a plain one of that name.
    fn material_of(&mut self, avatar: &Avatar, part: &RenderMesh) -> usize {
        let buffer = &mut self.buffer;
        let copied = (part.material_index).and_then(|m| self.materials.copy(m, buffer));
        if let Some(copied) = copied {
            return copied;
        }
        let tissue = avatar.tissue_vertices();
        let vertices = part.vertices.iter();
        let own = vertices.filter(|v| (**v as usize) < tissue).count();
        let colour = match () {
            () if !part.colours.is_empty() => WHITE,
            () if 2 * own < part.vertices.len() => ATTACHED,
            () => SKIN,
        };
        self.material(&part.material, colour, 0.6)
    }
}

/// The highest set of texture coordinates that a material takes, if it takes any.
fn highest_set(material: &Value) -> Option<usize> {
    let mut highest = None;
    for_textures(material, &mut |info| {
        highest = highest.max(coordinate_sets(info).into_iter().max());
    });
    highest
}

/// The skin as one part.
fn whole_skin(avatar: &Avatar) -> RenderMesh {
    RenderMesh {
        vertices: (0..avatar.body_vertices(0).start as u32).collect(),
        triangles: avatar.skin_triangles().to_vec(),
        ..RenderMesh::default()
    }
}

/// `values` of the skin vertices; attached vertices without triangles have those of the vertex that they
/// follow most.
fn of_followed(avatar: &Avatar, mut values: Vec<DVec3>) -> Vec<DVec3> {
    let mut has_triangle = vec![false; values.len()];
    for &v in avatar.triangles.iter().flatten() {
        has_triangle[v as usize] = true;
    }
    let first = avatar.tissue_vertices();
    for (k, row) in avatar.attached.iter().enumerate() {
        let followed = row.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some(&(v, _)) = followed.filter(|_| !has_triangle[first + k]) {
            values[first + k] = values[v as usize];
        }
    }
    values
}
