//! What a character's file says about the look of its surfaces.

use serde::{Deserialize, Serialize};

/// Materials, textures and images of a character's file, as glTF has them. Nothing here computes with them: they are
/// kept for who draws the avatar, or writes it ([`RenderMesh::material_index`](super::RenderMesh) counts `materials`).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Appearance {
    /// JSON of an object with glTF's lists `materials`, `textures` and `samplers`; empty where there is nothing. The images
    /// that textures name are those of [`Appearance::images`].
    pub gltf: String,
    /// Images in the file's order; those that no drawn part shows are empty.
    pub images: Vec<Image>,
}

/// An image as it is coded in its file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Image {
    /// Its name in the file, or nothing.
    pub name: String,
    /// What its bytes are: `image/png`, `image/jpeg`, …
    pub mime_type: String,
    /// Its bytes, or none.
    pub bytes: Vec<u8>,
}

impl Appearance {
    /// Whether nothing is said.
    pub fn is_empty(&self) -> bool {
        self.gltf.is_empty()
    }

    /// Bytes of all images together.
    pub fn image_bytes(&self) -> usize {
        self.images.iter().map(|image| image.bytes.len()).sum()
    }
}
