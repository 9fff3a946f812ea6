//! How files draw vertices.

use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// A part of a body as its file draws it: with the vertices that seams of texture coordinates split.
///
/// A *body vertex* is one of the welded skin's, or after those one of the attachments' in order: an
/// avatar's skin vertices are numbered so.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RenderMesh {
    /// Name of the mesh in the file.
    pub name: String,
    /// Name of its material, empty where it has none.
    pub material: String,
    /// Which of the file's materials that is, in the file's order; none where it has none, or in a baked file of before.
    /// In a section of its own ([`crate::file`]), as tangents, normals, colours and further coordinates are: files are read
    /// that have none.
    #[serde(skip)]
    pub material_index: Option<u32>,
    /// The body vertex of each of the part's own vertices.
    pub vertices: Vec<u32>,
    /// Texture coordinates of each of the part's own vertices, or none at all.
    pub texture_coordinates: Vec<[f32; 2]>,
    /// Tangent of each of the part's own vertices, or none at all: a unit vector in the reference shape, along the texture's
    /// u, and the sign of the bitangent, as glTF has them.
    #[serde(skip)]
    pub tangents: Vec<[f32; 4]>,
    /// Normal of each of the part's own vertices, or none at all: unit vectors in the reference shape, as the file has them.
    #[serde(skip)]
    pub normals: Vec<[f32; 3]>,
    /// Colour of each of the part's own vertices, or none at all: linear red, green, blue, and opacity, which multiply
    /// those of the material.
    #[serde(skip)]
    pub colours: Vec<[f32; 4]>,
    /// Further sets of texture coordinates, each like `texture_coordinates`, which is the first.
    #[serde(skip)]
    pub further_coordinates: Vec<Vec<[f32; 2]>>,
    /// Triangles of the part's own vertices.
    pub triangles: Vec<[u32; 3]>,
}

impl RenderMesh {
    /// Checks lengths and indices for `body_vertices`.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the part.
    pub fn validate(&self, body_vertices: usize) -> Result<()> {
        let own = self.vertices.len();
        let coordinates = &self.texture_coordinates;
        let sound = self.vertices.iter().all(|&v| (v as usize) < body_vertices)
            && (self.triangles.iter().flatten()).all(|&v| (v as usize) < own)
            && [coordinates]
                .into_iter()
                .chain(&self.further_coordinates)
                .all(|c| fits(c, own))
            && fits(&self.tangents, own)
            && fits(&self.normals, own)
            && fits(&self.colours, own);
        if sound {
            Ok(())
        } else {
            let problem = "names a vertex that is not there, or has other than one finite texture \
                           coordinate, tangent, normal or colour a vertex";
            Err(Error::invalid(format!("drawn.{}", self.name), problem))
        }
    }
}

/// Whether there is nothing, or one finite vector for each of `own` vertices.
fn fits<const N: usize>(values: &[[f32; N]], own: usize) -> bool {
    (values.is_empty() || values.len() == own)
        && values.as_flattened().iter().all(|c| c.is_finite())
}
