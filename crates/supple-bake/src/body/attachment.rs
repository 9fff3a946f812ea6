//! What is drawn with a body and is not its volume: clothes, hair, eyes.

use supple::internal::math::Rows;
use supple::model::{PoseBlend, SkinWeight, Surface};
use supple::{Error, Result};

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
