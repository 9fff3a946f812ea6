//! Arrays whose place in memory stays, for JavaScript to look at.

use supple::glam::{DVec3, Mat4};
use supple::model::Avatar;

/// One for each of the arrays; three numbers a vertex, sixteen a matrix.
#[derive(Default)]
pub struct Buffers {
    /// Of the skin.
    pub positions: Vec<f32>,
    pub normals: Vec<f32>,
    /// Of all drawn parts, one after the other.
    pub part_positions: Vec<f32>,
    pub part_normals: Vec<f32>,
    pub displacements: Vec<f32>,
    pub forces: Vec<f32>,
    /// One number a vertex.
    pub pressures: Vec<f32>,
    pub joints: Vec<f32>,
}

impl Buffers {
    /// Room for `avatar`.
    pub fn new(avatar: &Avatar) -> Self {
        let skin = avatar.skin.len();
        let parts: usize = (avatar.render_meshes.iter().map(|part| part.vertices.len())).sum();
        let zeros = |count: usize| vec![0.0; count];
        Self {
            positions: zeros(3 * skin),
            normals: zeros(3 * skin),
            part_positions: zeros(3 * parts),
            part_normals: zeros(3 * parts),
            displacements: zeros(3 * skin),
            forces: zeros(3 * skin),
            pressures: zeros(skin),
            joints: zeros(16 * avatar.joints.len()),
        }
    }

    /// The array that is called so in `index.js`.
    pub fn named(&self, name: &str) -> Option<&[f32]> {
        Some(match name {
            "positions" => &self.positions,
            "normals" => &self.normals,
            "partPositions" => &self.part_positions,
            "partNormals" => &self.part_normals,
            "displacements" => &self.displacements,
            "forces" => &self.forces,
            "pressures" => &self.pressures,
            "joints" => &self.joints,
            _ => return None,
        })
    }

    /// Takes the posed skin over, and what is drawn of it.
    pub fn set_skin(&mut self, avatar: &Avatar, positions: &[DVec3], normals: &[DVec3]) {
        write(&mut self.positions, positions);
        write(&mut self.normals, normals);
        let drawn = || avatar.render_meshes.iter().flat_map(|part| &part.vertices);
        for (all, of_parts) in [
            (&self.positions, &mut self.part_positions),
            (&self.normals, &mut self.part_normals),
        ] {
            let (all, _) = all.as_chunks::<3>();
            let (of_parts, _) = of_parts.as_chunks_mut::<3>();
            for (out, &v) in of_parts.iter_mut().zip(drawn()) {
                *out = all[v as usize];
            }
        }
    }

    /// Takes matrices of joints over, column by column.
    pub fn set_joints(&mut self, matrices: &[Mat4]) {
        let (out, _) = self.joints.as_chunks_mut::<16>();
        for (out, matrix) in out.iter_mut().zip(matrices) {
            *out = matrix.to_cols_array();
        }
    }
}

/// Vectors as f32.
pub fn write(out: &mut [f32], vectors: &[DVec3]) {
    let (out, _) = out.as_chunks_mut::<3>();
    for (out, vector) in out.iter_mut().zip(vectors) {
        *out = vector.as_vec3().to_array();
    }
}
