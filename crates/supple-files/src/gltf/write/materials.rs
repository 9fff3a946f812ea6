//! Materials of the character's file, copied with the textures, samplers and images that they need.
//!
//! What is copied is made sound on its way, wherever it comes from: what names something that is not there is left out, and
//! so are extensions that are not of materials or textures alone.

use super::buffer::Buffer;
use crate::gltf::appearance::{coordinate_sets, index, is_texture};
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, BTreeSet};
use supple::model::{Appearance, Image};
use supple::{Error, Result};

/// Deepest nesting that is copied.
const DEEPEST: usize = 32;

/// The highest set of texture coordinates that is written.
const HIGHEST_SET: usize = 7;

/// Extensions that concern nothing but materials and textures; a trailing `*` stands for any ending.
const KEPT: [&str; 8] = [
    "KHR_materials_*",
    "KHR_texture_*",
    "EXT_materials_*",
    "EXT_texture_*",
    "VRMC_materials_*",
    "ADOBE_materials_*",
    "MSFT_texture_dds",
    "MSFT_packing_*",
];

type Object = Map<String, Value>;

/// A file's materials, and where in the written file each went.
pub(super) struct Materials<'a> {
    from: Lists,
    pictures: &'a [Image],
    required: BTreeSet<String>,
    material_at: BTreeMap<u32, usize>,
    texture_at: BTreeMap<usize, Option<usize>>,
    sampler_at: BTreeMap<usize, usize>,
    image_at: BTreeMap<usize, usize>,
    /// What is written.
    pub to: Lists,
    pub images: Vec<Value>,
    extensions: BTreeSet<String>,
}

/// glTF's lists of that name.
#[derive(Default)]
pub(super) struct Lists {
    pub materials: Vec<Value>,
    pub textures: Vec<Value>,
    pub samplers: Vec<Value>,
}

impl<'a> Materials<'a> {
    /// # Errors
    /// [`Error::Invalid`] where the appearance is no JSON object.
    pub fn new(appearance: &'a Appearance) -> Result<Self> {
        let mut object = match appearance.is_empty() {
            true => Object::new(),
            false => serde_json::from_str(&appearance.gltf).map_err(|e| {
                Error::invalid("appearance.gltf", format!("is no JSON object: {e}"))
            })?,
        };
        let mut list = |key: &str| match object.remove(key) {
            Some(Value::Array(list)) => list,
            _ => Vec::new(),
        };
        let required = list("extensionsRequired");
        Ok(Self {
            required: (required.iter().filter_map(Value::as_str))
                .map(String::from)
                .collect(),
            from: Lists {
                materials: list("materials"),
                textures: list("textures"),
                samplers: list("samplers"),
            },
            pictures: &appearance.images,
            material_at: BTreeMap::new(),
            texture_at: BTreeMap::new(),
            sampler_at: BTreeMap::new(),
            image_at: BTreeMap::new(),
            to: Lists::default(),
            images: Vec::new(),
            extensions: BTreeSet::new(),
        })
    }

    /// The number in the written file of the `material`th of the source; nothing where there is none.
    pub fn copy(&mut self, material: u32, buffer: &mut Buffer) -> Option<usize> {
        if let Some(at) = self.material_at.get(&material) {
            return Some(*at);
        }
        let from = self.from.materials.get(material as usize)?.as_object()?;
        let mut copied = from.clone();
        self.clean(&mut copied, 0, buffer);
        let at = self.push(copied.into());
        self.material_at.insert(material, at);
        Some(at)
    }

    fn push(&mut self, material: Value) -> usize {
        self.to.materials.push(material);
        self.to.materials.len() - 1
    }

    /// The number of a material of this program's own; what is alike is one.
    pub fn plain(&mut self, material: Value) -> usize {
        let known = self.to.materials.iter().position(|m| *m == material);
        known.unwrap_or_else(|| self.push(material))
    }

    /// Extensions of what was copied, and those of them that the source requires.
    pub fn extensions(&self) -> (Vec<&String>, Vec<&String>) {
        let required = self.extensions.intersection(&self.required);
        (self.extensions.iter().collect(), required.collect())
    }

    /// Brings the textures below `object` to the written file's numbers.
    fn clean(&mut self, object: &mut Object, depth: usize, buffer: &mut Buffer) {
        let before = std::mem::take(object);
        for (key, mut value) in before {
            if let Some(inner) = value.as_object_mut().filter(|_| key != "extras") {
                if depth == DEEPEST {
                    continue;
                }
                if is_texture(&key) {
                    let highest = coordinate_sets(inner).into_iter().max();
                    let texture = index(inner, "index")
                        .filter(|_| highest <= Some(HIGHEST_SET))
                        .and_then(|t| self.texture(t, buffer));
                    let Some(texture) = texture else { continue };
                    inner.insert("index".into(), json!(texture));
                }
                if key == "extensions" {
                    self.keep_extensions(inner);
                }
                self.clean(inner, depth + 1, buffer);
                if key == "extensions" && inner.is_empty() {
                    continue;
                }
            }
            object.insert(key, value);
        }
    }

    fn keep_extensions(&mut self, extensions: &mut Object) {
        extensions.retain(|name, value| is_kept(name) && value.is_object());
        self.extensions.extend(extensions.keys().cloned());
    }

    fn texture(&mut self, texture: usize, buffer: &mut Buffer) -> Option<usize> {
        if let Some(at) = self.texture_at.get(&texture) {
            return *at;
        }
        let at = self.new_texture(texture, buffer).map(|copied| {
            self.to.textures.push(copied.into());
            self.to.textures.len() - 1
        });
        self.texture_at.insert(texture, at);
        at
    }

    /// A texture that has a picture.
    fn new_texture(&mut self, texture: usize, buffer: &mut Buffer) -> Option<Object> {
        let from = self.from.textures.get(texture)?.as_object()?.clone();
        let mut copied = Object::new();
        for key in ["name", "extras"] {
            copied.extend(from.get(key).map(|value| (key.into(), value.clone())));
        }
        let sampler = index(&from, "sampler").and_then(|s| self.sampler(s));
        copied.extend(sampler.map(|s| ("sampler".into(), json!(s))));
        let plain = ["image/png", "image/jpeg"];
        let source = index(&from, "source").and_then(|i| self.image(i, &plain, buffer));
        copied.extend(source.map(|i| ("source".into(), json!(i))));
        let mut extensions = Object::new();
        let of_from = from.get("extensions").and_then(Value::as_object);
        for (name, value) in of_from.into_iter().flatten() {
            let coded = match name.as_str() {
                "KHR_texture_basisu" => "image/ktx2",
                "EXT_texture_webp" => "image/webp",
                "EXT_texture_avif" => "image/avif",
                "MSFT_texture_dds" => "image/vnd-ms.dds",
                _ => continue,
            };
            let source = value.as_object().and_then(|v| index(v, "source"));
            if let Some(image) = source.and_then(|i| self.image(i, &[coded], buffer)) {
                extensions.insert(name.clone(), json!({"source": image}));
            }
        }
        if source.is_none() && extensions.is_empty() {
            return None;
        }
        self.keep_extensions(&mut extensions);
        if !extensions.is_empty() {
            copied.insert("extensions".into(), extensions.into());
        }
        Some(copied)
    }

    fn sampler(&mut self, sampler: usize) -> Option<usize> {
        if let Some(at) = self.sampler_at.get(&sampler) {
            return Some(*at);
        }
        let mut copied = self.from.samplers.get(sampler)?.as_object()?.clone();
        copied.remove("extensions");
        self.to.samplers.push(copied.into());
        let at = self.to.samplers.len() - 1;
        self.sampler_at.insert(sampler, at);
        Some(at)
    }

    /// An image of one of the `kinds`.
    fn image(&mut self, image: usize, kinds: &[&str], buffer: &mut Buffer) -> Option<usize> {
        let picture = self.pictures.get(image)?;
        if picture.bytes.is_empty() || !kinds.contains(&&*picture.mime_type) {
            return None;
        }
        if let Some(at) = self.image_at.get(&image) {
            return Some(*at);
        }
        let view = buffer.view(picture.bytes.iter().copied());
        let mut copied = json!({"bufferView": view, "mimeType": picture.mime_type});
        if !picture.name.is_empty() {
            copied["name"] = json!(picture.name);
        }
        self.images.push(copied);
        let at = self.images.len() - 1;
        self.image_at.insert(image, at);
        Some(at)
    }
}

fn is_kept(extension: &str) -> bool {
    KEPT.iter().any(|known| match known.strip_suffix('*') {
        Some(start) => extension.starts_with(start),
        None => extension == *known,
    })
}
