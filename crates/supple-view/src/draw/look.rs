//! How a character's file paints its parts, read from what its avatar keeps of glTF. Images are decoded here, beside the
//! interface; the device gets them later.

use super::texture::Mipmaps;
use serde_json::Value;
use supple::model::{Appearance, Image};

/// The paint of all parts.
#[derive(Clone, Debug, Default)]
pub struct Look {
    /// In the file's order.
    pub materials: Vec<Material>,
    /// What materials name; none of what cannot be decoded.
    pub images: Vec<Option<Mipmaps>>,
}

/// What a part is painted with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Multiplies the image.
    pub colour: [f32; 4],
    /// Of the base colour; none where it is white.
    pub image: Option<usize>,
    /// Of the normals.
    pub normals: Option<usize>,
    /// How strong those are.
    pub bumps: f32,
    /// Below this alpha nothing is drawn.
    pub cutoff: f32,
    /// How much it shines by itself: unlit materials do.
    pub glow: f32,
}

impl Material {
    /// Of a part without one.
    pub const PLAIN: Self = Self {
        colour: [0.69, 0.41, 0.3, 1.0],
        image: None,
        normals: None,
        bumps: 1.0,
        cutoff: 0.0,
        glow: 0.0,
    };
}

impl Look {
    /// Of a character's file.
    pub fn new(appearance: &Appearance) -> Self {
        let gltf: Value = serde_json::from_str(&appearance.gltf).unwrap_or_default();
        let list = |key: &str| gltf[key].as_array().map_or(&[][..], Vec::as_slice);
        let textures = list("textures");
        let source = |texture: &Value| {
            let texture = textures.get(texture["index"].as_u64()? as usize)?;
            Some(texture["source"].as_u64()? as usize)
        };
        let material = |m: &Value| {
            let paint = &m["pbrMetallicRoughness"];
            let number = |v: &Value| v.as_f64().map(|x| x as f32);
            let factor = |k: usize| number(&paint["baseColorFactor"][k]).unwrap_or(1.0);
            let unlit = !m["extensions"]["KHR_materials_unlit"].is_null()
                || !m["extensions"]["VRMC_materials_mtoon"].is_null();
            Material {
                colour: [0, 1, 2, 3].map(factor),
                image: source(&paint["baseColorTexture"]),
                normals: source(&m["normalTexture"]),
                bumps: number(&m["normalTexture"]["scale"]).unwrap_or(1.0),
                cutoff: match m["alphaMode"].as_str() {
                    // Nothing is sorted here: what is half transparent is there or not.
                    Some("MASK" | "BLEND") => number(&m["alphaCutoff"]).unwrap_or(0.5),
                    _ => 0.0,
                },
                glow: if unlit { 0.35 } else { 0.0 },
            }
        };
        let materials: Vec<_> = list("materials").iter().map(material).collect();
        let wanted = |i: usize| {
            let names = |m: &Material| m.image == Some(i) || m.normals == Some(i);
            materials.iter().any(names)
        };
        let images = appearance.images.iter().enumerate();
        let images = images.map(|(i, image)| wanted(i).then(|| decoded(image)).flatten());
        Self {
            images: images.collect(),
            materials,
        }
    }
}

/// Longest side of an image on the device, pixels.
const LONGEST: u32 = 4096;

fn decoded(coded: &Image) -> Option<Mipmaps> {
    let mut reader = image::ImageReader::new(std::io::Cursor::new(&coded.bytes));
    // A file may claim any size.
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(2 * LONGEST);
    limits.max_image_height = Some(2 * LONGEST);
    reader.limits(limits);
    let image = reader.with_guessed_format().ok()?.decode().ok()?;
    let image = match image.width().max(image.height()) > LONGEST {
        true => image.thumbnail(LONGEST, LONGEST),
        false => image,
    };
    Some(Mipmaps::new(image.into_rgba8()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn materials_name_the_images_of_their_textures() {
        let appearance = Appearance {
            gltf: r#"{"textures": [{"source": 1}, {"source": 0}], "materials": [
                {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "baseColorFactor": [0.5, 1, 1, 1]}},
                {"normalTexture": {"index": 1, "scale": 0.25}, "alphaMode": "MASK"}]}"#
                .into(),
            images: vec![Image::default(), Image::default()],
        };
        let look = Look::new(&appearance);
        let [painted, bumpy] = look.materials[..] else {
            panic!("{:?}", look.materials)
        };
        assert_eq!(
            (painted.image, painted.normals, painted.colour[0]),
            (Some(1), None, 0.5)
        );
        assert_eq!(
            (bumpy.image, bumpy.normals, bumpy.bumps),
            (None, Some(0), 0.25)
        );
        assert_eq!((painted.cutoff, bumpy.cutoff), (0.0, 0.5));
        // What is no image is none, and the material stays.
        assert!(look.images.iter().all(Option::is_none));
        assert!(Look::new(&Appearance::default()).materials.is_empty());
    }
}
