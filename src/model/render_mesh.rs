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
    /// The body vertex of each of the part's own vertices.
    pub vertices: Vec<u32>,
    /// Texture coordinates of each of the part's own vertices, or none at all.
    pub texture_coordinates: Vec<[f32; 2]>,
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
            && (coordinates.is_empty() || coordinates.len() == own)
            && coordinates.iter().flatten().all(|c| c.is_finite());
        if sound {
            Ok(())
        } else {
            let problem = "names a vertex that is not there, or has other than one finite texture \
                           coordinate a vertex";
            Err(Error::invalid(format!("drawn.{}", self.name), problem))
        }
    }
}
