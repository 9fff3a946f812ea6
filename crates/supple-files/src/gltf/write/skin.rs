//! The skinned mesh: a primitive for each part that the body's file draws, or one of the whole skin.
//!
//! Parts keep their file's vertices and with them the seams of its texture coordinates. Materials keep
//! their names; the textures themselves stay in the file that the body came from.

use super::document::{Document, as_floats, floats};
use super::morph::Morphs;
use super::normals::normal_change;
use glam::{DMat4, DVec3};
use serde_json::{Value, json};
use supple::model::{Avatar, RenderMesh, SkinWeight, Surface};

/// Displacements shorter than this are left out of a sparse target, m.
const SPARSE_THRESHOLD: f32 = 1e-7;

/// Changes of normals whose components are all smaller are left out.
const NORMAL_THRESHOLD: f32 = 1e-4;

const SKIN: [f32; 3] = [0.80, 0.52, 0.41];
/// Of what is attached to the skin.
const ATTACHED: [f32; 3] = [0.45, 0.47, 0.52];

impl Document {
    /// The skinned mesh of an avatar.
    pub fn skin(&mut self, avatar: &Avatar, morphs: &Morphs, bones: &[usize]) {
        let surface = Surface {
            positions: avatar.skin.position.clone(),
            triangles: avatar.triangles.clone(),
        };
        let normals = of_followed(avatar, surface.vertex_normals().into_iter().map(floats));
        // Each target's displacement of positions and of normals.
        let targets: Vec<(&[DVec3], Vec<[f32; 3]>)> = (morphs.targets.iter())
            .map(|target| {
                let change = normal_change(&surface, target).into_iter();
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
        let mut materials: Vec<(&str, bool, usize)> = Vec::new();
        let mut primitives: Vec<Value> = Vec::new();
        // A primitive must draw something.
        for part in parts.iter().filter(|p| !p.triangles.is_empty()) {
            let tissue = avatar.tissue_vertices();
            let own = part
                .vertices
                .iter()
                .filter(|v| (**v as usize) < tissue)
                .count();
            let attached = 2 * own < part.vertices.len();
            let known = |m: &&(&str, bool, usize)| m.0 == part.material && m.1 == attached;
            let material = match materials.iter().find(known) {
                Some(known) => known.2,
                None => {
                    let colour = if attached { ATTACHED } else { SKIN };
                    let material = self.material(&part.material, colour, 0.6);
                    materials.push((&part.material, attached, material));
                    material
                }
            };
            let mut primitive = self.part(avatar, part, &normals);
            primitive["material"] = json!(material);
            if !targets.is_empty() {
                let targets = targets.iter().map(|(moves, normals)| {
                    let moves: Vec<_> = of_part(part, moves).map(floats).collect();
                    let normals: Vec<_> = of_part(part, normals).collect();
                    json!({
                        "POSITION": self.buffer.sparse_vectors(&moves, SPARSE_THRESHOLD),
                        "NORMAL": self.buffer.sparse_vectors(&normals, NORMAL_THRESHOLD),
                    })
                });
                primitive["targets"] = json!(targets.collect::<Vec<_>>());
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

    /// A part's own vertices and triangles.
    fn part(&mut self, avatar: &Avatar, part: &RenderMesh, normals: &[[f32; 3]]) -> Value {
        let skin = &avatar.skin;
        let positions: Vec<_> = of_part(part, &skin.position).map(floats).collect();
        let normals: Vec<_> = of_part(part, normals).collect();
        let mut attributes = json!({
            "POSITION": self.buffer.floats("VEC3", &positions),
            "NORMAL": self.buffer.floats("VEC3", &normals),
        });
        if !part.texture_coordinates.is_empty() {
            let coordinates = self.buffer.floats("VEC2", &part.texture_coordinates);
            attributes["TEXCOORD_0"] = json!(coordinates);
        }
        for set in 0..skin.skinning.longest().div_ceil(4) {
            let rows = part.vertices.iter().map(|&v| skin.skinning.row(v as usize));
            let (bones, weights): (Vec<_>, Vec<_>) = rows.map(|row| influences(row, set)).unzip();
            attributes[format!("JOINTS_{set}")] = json!(self.buffer.bone_indices(&bones));
            attributes[format!("WEIGHTS_{set}")] = json!(self.buffer.floats("VEC4", &weights));
        }
        let indices = self.buffer.triangles(&part.triangles);
        json!({"attributes": attributes, "indices": indices})
    }
}

fn of_part<'a, T: Copy>(part: &'a RenderMesh, values: &'a [T]) -> impl Iterator<Item = T> + 'a {
    part.vertices.iter().map(|&v| values[v as usize])
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
fn of_followed(avatar: &Avatar, values: impl Iterator<Item = [f32; 3]>) -> Vec<[f32; 3]> {
    let mut values: Vec<[f32; 3]> = values.collect();
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
