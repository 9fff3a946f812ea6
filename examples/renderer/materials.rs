//! Base colours of a glTF file's materials, in the file's order: what `RenderMesh::material_index` counts.

use image::RgbaImage;
use std::path::Path;

/// What a part is painted with.
pub struct Material {
    /// Multiplies the image.
    pub colour: [f32; 4],
    /// None where it is white.
    pub image: Option<RgbaImage>,
    /// Below this alpha nothing is drawn.
    pub cutoff: f32,
}

/// Of a part without one.
pub const PLAIN: Material = Material {
    colour: [0.69, 0.41, 0.3, 1.0],
    image: None,
    cutoff: 0.0,
};

/// The materials of a file; none of one that is no glTF.
pub fn read(path: &Path) -> Vec<Material> {
    let Ok(file) = gltf::Gltf::open(path) else {
        return Vec::new();
    };
    let of = |material: gltf::Material<'_>| {
        let paint = material.pbr_metallic_roughness();
        let image = paint.base_color_texture().and_then(|texture| {
            let bytes = bytes(&file, texture.texture().source().source(), path)?;
            Some(image::load_from_memory(&bytes).ok()?.to_rgba8())
        });
        Material {
            colour: paint.base_color_factor(),
            image,
            cutoff: match material.alpha_mode() {
                gltf::material::AlphaMode::Opaque => 0.0,
                // Nothing is sorted here: what is half transparent is there or not.
                gltf::material::AlphaMode::Mask | gltf::material::AlphaMode::Blend => {
                    material.alpha_cutoff().unwrap_or(0.5)
                }
            },
        }
    };
    file.materials().map(of).collect()
}

/// A PNG or JPEG in the file or beside it.
fn bytes(file: &gltf::Gltf, source: gltf::image::Source<'_>, path: &Path) -> Option<Vec<u8>> {
    match source {
        gltf::image::Source::View { view, .. } => {
            let range = view.offset()..view.offset() + view.length();
            Some(file.blob.as_ref()?.get(range)?.to_vec())
        }
        gltf::image::Source::Uri { uri, .. } => std::fs::read(path.with_file_name(uri)).ok(),
    }
}
