//! Materials, textures and images of a file, as they are (glTF 2.0, §3.8 and §3.9).
//!
//! None of it changes a body, so nothing of it refuses a file: an image that cannot be had is left out, with a note.

use super::container::{File, load};
use super::document::Image as FileImage;
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;
use supple::model::{Appearance, Image};

/// Images of one file, all together, bytes. Four textures of 4096² as PNG are half of it.
const MOST_IMAGE_BYTES: u64 = 1 << 28;

/// Most sets of texture coordinates besides the first.
const MOST_SETS: usize = 7;

/// Deepest nesting that is looked into; materials need five.
const DEEPEST: usize = 32;

/// What the materials that are `used` (their indices) need, and notes on what of it is missing.
pub(super) fn appearance(
    file: &File,
    used: impl Iterator<Item = u32>,
) -> (Appearance, Vec<String>) {
    let document = &file.document;
    let used: BTreeSet<u32> = used.collect();
    if used.is_empty() {
        return Default::default();
    }
    let mut textures = BTreeSet::new();
    for material in used
        .iter()
        .filter_map(|m| document.materials.get(*m as usize))
    {
        for_textures(material, &mut |info| textures.extend(index(info, "index")));
    }
    let mut shown = BTreeSet::new();
    for texture in textures.iter().filter_map(|t| document.textures.get(*t)) {
        shown.extend(image_sources(texture));
    }
    let mut images = vec![Image::default(); document.images.len()];
    let mut budget = Budget::new(file);
    let mut notes = Vec::new();
    for i in shown {
        let Some(image) = document.images.get(i) else {
            continue;
        };
        match read(file, image, &mut budget) {
            Ok(read) => images[i] = read,
            Err(problem) => {
                let name = image.name.as_deref().unwrap_or_default();
                notes.push(format!("images[{i}] {name:?} was left out: {problem}"));
            }
        }
    }
    let gltf = json!({
        "materials": document.materials,
        "textures": document.textures,
        "samplers": document.samplers,
        "extensionsRequired": document.extensions_required,
    });
    let gltf = gltf.to_string();
    (Appearance { gltf, images }, notes)
}

/// How many more bytes of images are read.
struct Budget {
    /// Of those in buffers: as many as these have, since views may overlap.
    inside: u64,
    outside: u64,
}

impl Budget {
    fn new(file: &File) -> Self {
        let buffers: usize = file.buffers.iter().map(Vec::len).sum();
        Self {
            inside: MOST_IMAGE_BYTES.min(buffers as u64),
            outside: MOST_IMAGE_BYTES,
        }
    }
}

fn spend(budget: &mut u64, bytes: usize) -> Result<(), String> {
    let rest = budget.checked_sub(bytes as u64);
    *budget = rest.ok_or("the images are more bytes, all together, than are kept")?;
    Ok(())
}

/// The bytes of an image of `file`.
fn read(file: &File, image: &FileImage, budget: &mut Budget) -> Result<Image, String> {
    let bytes = match (image.buffer_view, &image.uri) {
        (Some(view), _) => {
            let bytes = file.view(view)?;
            spend(&mut budget.inside, bytes.len())?;
            bytes.to_vec()
        }
        (None, Some(uri)) => {
            let bytes = load(uri, &file.path, budget.outside)?;
            spend(&mut budget.outside, bytes.len())?;
            bytes
        }
        (None, None) => return Err("it has neither a bufferView nor a uri".into()),
    };
    let mime_type =
        (mime_type(&bytes)).ok_or("its bytes are no picture of a kind that glTF has")?;
    Ok(Image {
        name: image.name.clone().unwrap_or_default(),
        mime_type: mime_type.into(),
        bytes,
    })
}

/// What a picture's first bytes say that it is.
fn mime_type(bytes: &[u8]) -> Option<&'static str> {
    let at = |place: usize, what: &[u8]| bytes.get(place..).is_some_and(|b| b.starts_with(what));
    Some(match () {
        () if at(0, b"\x89PNG\r\n\x1a\n") => "image/png",
        () if at(0, b"\xff\xd8\xff") => "image/jpeg",
        () if at(0, b"RIFF") && at(8, b"WEBP") => "image/webp",
        () if at(0, b"\xabKTX 20\xbb\r\n\x1a\n") => "image/ktx2",
        () if at(4, b"ftypavif") => "image/avif",
        () if at(0, b"DDS ") => "image/vnd-ms.dds",
        () => return None,
    })
}

/// Calls `visit` with each texture that a material names: objects under keys like `normalTexture`, also in extensions.
pub(super) fn for_textures(material: &Value, visit: &mut dyn FnMut(&Map<String, Value>)) {
    fn walk(value: &Value, depth: usize, visit: &mut dyn FnMut(&Map<String, Value>)) {
        let Some(object) = value.as_object().filter(|_| depth < DEEPEST) else {
            return;
        };
        for (key, value) in object.iter().filter(|(key, _)| *key != "extras") {
            match value.as_object() {
                Some(info) if is_texture(key) => visit(info),
                _ => walk(value, depth + 1, visit),
            }
        }
    }
    walk(material, 0, visit);
}

/// Whether a material's `key` is that of a texture.
pub(super) fn is_texture(key: &str) -> bool {
    key.ends_with("Texture")
}

/// A whole number in an object.
pub(super) fn index(object: &Map<String, Value>, key: &str) -> Option<usize> {
    object.get(key)?.as_u64().and_then(|v| v.try_into().ok())
}

/// The set of coordinates that a texture of a material takes.
pub(super) fn coordinate_sets(info: &Map<String, Value>) -> [usize; 2] {
    let own = index(info, "texCoord").unwrap_or(0);
    let transform = || {
        info.get("extensions")?
            .get("KHR_texture_transform")?
            .as_object()
    };
    let transformed = transform().and_then(|t| index(t, "texCoord"));
    [own, transformed.unwrap_or(own)]
}

/// The highest set of texture coordinates that a material names, of those that are read.
pub(super) fn highest_coordinates(material: &Value) -> usize {
    let mut highest = 0;
    for_textures(material, &mut |info| {
        highest = coordinate_sets(info).into_iter().fold(highest, usize::max);
    });
    highest.min(MOST_SETS)
}

/// Images that a texture, or an extension of it, names.
fn image_sources(texture: &Value) -> Vec<usize> {
    let extensions = texture.get("extensions").and_then(Value::as_object);
    let all = extensions
        .into_iter()
        .flat_map(Map::values)
        .chain([texture]);
    all.filter_map(|t| index(t.as_object()?, "source"))
        .collect()
}
