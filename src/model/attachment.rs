//! What is drawn with a body and is not its volume: clothes, hair, eyes; and how files draw vertices.

use super::{PoseBlend, SkinWeight, Surface};
use crate::math::Rows;
use crate::{Error, Result};
use serde::{Deserialize, Serialize};

/// A surface that is not part of the closed skin. It has no tissue, no mass and touches nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attachment {
    /// What it is called in reports.
    pub name: String,
    /// The surface, in the reference shape, m; it may be open.
    pub surface: Surface,
    /// Bones of each vertex.
    pub skinning: Rows<SkinWeight>,
    /// Pose blend shapes at its vertices.
    pub pose_blend: PoseBlend,
    /// Whether it follows the nearest tissue; otherwise its bones alone move it.
    pub follows_tissue: bool,
}

impl Attachment {
    /// Checks every length, index and number for a skeleton of `bones`.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the attachment.
    pub fn validate(&self, bones: usize) -> Result<()> {
        let vertices = self.surface.positions.len();
        let field = || format!("attachments.{}", self.name);
        self.skinning.validate(&field(), vertices)?;
        let sound = self.surface.positions.iter().all(|p| p.is_finite())
            && (self.surface.triangles.iter().flatten()).all(|&v| (v as usize) < vertices)
            && (self.skinning.entries().iter())
                .all(|w| (w.bone as usize) < bones && w.weight.is_finite())
            && self.pose_blend.features.checked_mul(vertices)
                == Some(self.pose_blend.columns.len());
        if sound {
            Ok(())
        } else {
            let problem = "holds a value that is not finite, or names what is not there";
            Err(Error::invalid(field(), problem))
        }
    }
}

/// A part of a body as its file draws it: with the vertices that seams of texture coordinates split.
///
/// A *body vertex* is one of the welded skin's, or after those one of the attachments' in order: an
/// avatar's skin vertices are numbered so.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DrawnPart {
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

impl DrawnPart {
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
