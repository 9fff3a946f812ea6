//! Where an avatar comes from: a baked file, or a body and how it is baked.

mod cache;
mod keys;
mod shape;

pub use cache::load_avatar;

use crate::scene::parse_toml;
use keys::Keys;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use supple::model::{Surface, UpAxis};
use supple::{Error, Result};
use supple_bake::{Body, Recipe};
use supple_files::{
    CharacterFile, CharacterOptions, FileKind, PartNames, read_character, read_closed_obj,
    read_painted, read_tets, read_text, read_toml_text,
};
use supple_samples::{Sample, limb_recipe};

/// An avatar's source.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Keys", into = "Keys")]
pub enum AvatarSource {
    /// A baked file.
    Baked(PathBuf),
    /// A TOML file that says it.
    Recipe(PathBuf),
    /// A body to be baked.
    Body(Box<BodySource>),
}

/// A body, and how it is baked.
#[derive(Clone, Debug, PartialEq)]
pub struct BodySource {
    /// The body.
    pub from: BodyOrigin,
    /// The size of the file's unit, m: 0.01 for centimetres. 1 if not given.
    pub scale: Option<f64>,
    /// The axis that points up in the file, in place of what its kind says.
    pub up: Option<UpAxis>,
    /// How it is baked; each sample has its own default.
    pub bake: Option<Recipe>,
}

/// Where a body comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum BodyOrigin {
    /// It is made by the program.
    Sample {
        /// Which.
        sample: Sample,
        /// Its shape; [`Sample::Body`] alone has several.
        betas: Vec<f64>,
    },
    /// It is a file's.
    Character(CharacterSource),
    /// Tets alone: a body around one bone, whose rest shape is that without gravity.
    Tets {
        /// Their file ([`read_tets`]).
        mesh: PathBuf,
        /// Bones that the regions of `mesh` are, by its labels.
        regions: BTreeMap<String, String>,
    },
}

/// A character file of any kind that [`read_character`] knows, and what goes with it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CharacterSource {
    /// The file.
    pub model: PathBuf,
    /// Shape parameters in the file's order.
    pub betas: Vec<f64>,
    /// A motion of AMASS whose person's shape it takes.
    pub betas_of: Option<PathBuf>,
    /// Closed bone surfaces: OBJ objects with its bones' names.
    pub bones: Option<PathBuf>,
    /// Tets of its soft layer ([`read_tets`]).
    pub mesh: Option<PathBuf>,
    /// Bones that the regions of `mesh` are, by its labels; a label that is a bone's name needs no entry.
    pub regions: BTreeMap<String, String>,
    /// Maps painted on the skin, by name.
    pub painted: BTreeMap<String, PathBuf>,
    /// Parts of it that are tissue or rigid, against what is chosen.
    pub parts: PartNames,
}

impl CharacterSource {
    /// The file `model` alone.
    pub fn new(model: impl Into<PathBuf>) -> Self {
        Self {
            model: model.into(),
            ..Self::default()
        }
    }

    fn options(&self) -> CharacterOptions {
        CharacterOptions {
            betas: self.betas.clone(),
            betas_of: self.betas_of.clone(),
            regions: self.regions.clone(),
            parts: self.parts.clone(),
        }
    }

    fn read(&self) -> Result<CharacterFile> {
        let mut character = read_character(&self.model, &self.options())?;
        if let Some(path) = &self.bones {
            let body = &mut character.body;
            body.bone_surfaces = bones_by_name(&body.skeleton.names, path)?;
        }
        if let Some(path) = &self.mesh {
            let tets = read_tets(path)?;
            let put = tets.put_into(&mut character.body, &self.regions);
            put.map_err(|e| e.of_file(path))?;
        }
        for (name, path) in &self.painted {
            let map = read_painted(path, name)?;
            character.paint(name, &map).map_err(|e| e.of_file(path))?;
        }
        Ok(character)
    }
}

impl From<BodySource> for AvatarSource {
    fn from(body: BodySource) -> Self {
        Self::Body(Box::new(body))
    }
}

impl From<BodyOrigin> for AvatarSource {
    fn from(from: BodyOrigin) -> Self {
        BodySource {
            from,
            scale: None,
            up: None,
            bake: None,
        }
        .into()
    }
}

impl From<CharacterSource> for AvatarSource {
    fn from(character: CharacterSource) -> Self {
        BodyOrigin::Character(character).into()
    }
}

/// Reads an avatar's source from the TOML file at `path`; files that it names lie relative to it.
///
/// # Errors
/// [`Error::Io`], [`Error::Format`] with line or key.
pub fn read_avatar_source(path: impl AsRef<Path>) -> Result<AvatarSource> {
    let path = path.as_ref();
    parse_avatar_source(&read_text(path)?, path)
}

/// Reads an avatar's source from TOML `text` of the file at `path`. See [`read_avatar_source`].
pub fn parse_avatar_source(text: &str, path: &Path) -> Result<AvatarSource> {
    let mut source: AvatarSource = parse_toml(text, path)?;
    source.resolve(path.parent().unwrap_or(Path::new("")));
    Ok(source)
}

/// The source that any file stands for: a recipe, a scene (its `avatar` table), or a character file.
///
/// # Errors
/// [`Error::Io`], [`Error::Format`] with line or key; of a file of another kind it says what can be read.
pub fn avatar_source_of(path: impl AsRef<Path>) -> Result<AvatarSource> {
    let path = path.as_ref();
    match FileKind::of(path)? {
        FileKind::Character(_) => Ok(CharacterSource::new(path).into()),
        FileKind::Baked => Ok(AvatarSource::Baked(path.into())),
        FileKind::Toml => {
            let text = read_toml_text(path)?;
            let table: toml::Table = parse_toml(&text, path)?;
            if table.contains_key("avatar") {
                Ok(crate::scene::read_scene(path)?.avatar)
            } else {
                read_avatar_source(path)
            }
        }
    }
}

/// A recipe for a model that is named elsewhere; one that it names itself is left out.
///
/// # Errors
/// As [`read_avatar_source`].
pub fn read_recipe_for(recipe: impl AsRef<Path>, model: &Path) -> Result<AvatarSource> {
    let path = recipe.as_ref();
    let text = read_toml_text(path)?;
    let keys: Keys = parse_toml(&text, path)?;
    let keys = Keys {
        file: None,
        recipe: None,
        sample: None,
        mesh: None,
        model: Some(model.into()),
        ..keys
    };
    let mut source = AvatarSource::try_from(keys).map_err(|e| e.of_file(path))?;
    source.resolve(path.parent().unwrap_or(Path::new("")));
    if let AvatarSource::Body(body) = &mut source
        && let BodyOrigin::Character(character) = &mut body.from
    {
        character.model = model.into();
    }
    Ok(source)
}

impl AvatarSource {
    /// The source of a sample with its own recipe.
    pub fn of_sample(sample: Sample) -> Self {
        BodyOrigin::Sample {
            sample,
            betas: Vec::new(),
        }
        .into()
    }

    /// The body, where one is to be baked.
    pub fn body_source(&self) -> Option<&BodySource> {
        match self {
            Self::Body(body) => Some(body),
            _ => None,
        }
    }

    /// The character file, where the body is one's.
    pub fn model(&self) -> Option<&Path> {
        match &self.body_source()?.from {
            BodyOrigin::Character(character) => Some(&character.model),
            _ => None,
        }
    }

    /// The sample, where the body is one.
    pub fn sample(&self) -> Option<Sample> {
        match self.body_source()?.from {
            BodyOrigin::Sample { sample, .. } => Some(sample),
            _ => None,
        }
    }

    /// The same body baked by `recipe`.
    ///
    /// # Errors
    /// [`Error::Invalid`] of what is baked already, or has its own recipe.
    pub fn baked_by(mut self, recipe: Recipe) -> Result<Self> {
        match &mut self {
            Self::Body(body) => body.bake = Some(recipe),
            _ => return Err(Error::invalid("avatar", "is no body to bake")),
        }
        Ok(self)
    }

    /// The recipe's text, as [`parse_avatar_source`] reads it.
    ///
    /// # Errors
    /// [`Error::Invalid`] of what TOML cannot say.
    pub fn to_toml(&self) -> Result<String> {
        toml::to_string_pretty(self)
            .map_err(|e| Error::invalid("recipe", format!("cannot be written as TOML: {e}")))
    }

    /// Puts relative paths into `folder`.
    pub fn resolve(&mut self, folder: &Path) {
        let put = |path: &mut PathBuf| *path = folder.join(&*path);
        match self {
            Self::Baked(path) | Self::Recipe(path) => put(path),
            Self::Body(body) => match &mut body.from {
                BodyOrigin::Sample { .. } => {}
                BodyOrigin::Tets { mesh, .. } => put(mesh),
                BodyOrigin::Character(character) => {
                    put(&mut character.model);
                    character.betas_of.iter_mut().for_each(put);
                    character.bones.iter_mut().for_each(put);
                    character.mesh.iter_mut().for_each(put);
                    character.painted.values_mut().for_each(put);
                }
            },
        }
    }

    /// Every file that the body is read from.
    pub fn files(&self) -> Vec<&Path> {
        match self.body_source().map(|body| &body.from) {
            None | Some(BodyOrigin::Sample { .. }) => Vec::new(),
            Some(BodyOrigin::Tets { mesh, .. }) => vec![mesh],
            Some(BodyOrigin::Character(c)) => {
                let own = [&c.mesh, &c.bones, &c.betas_of].into_iter().flatten();
                (own.chain([&c.model]))
                    .chain(c.painted.values())
                    .map(PathBuf::as_path)
                    .collect()
            }
        }
    }

    /// The body to be baked, and how.
    ///
    /// # Errors
    /// What reading, generating and meshing say; [`Error::Format`] of a source that is baked already.
    pub fn body(&self) -> Result<(Body, Recipe)> {
        let SourceBody { body, recipe, .. } = self.read()?;
        Ok((body, recipe))
    }

    /// The body to be baked, how, and what was decided about its file.
    ///
    /// # Errors
    /// As [`AvatarSource::body`].
    pub fn read(&self) -> Result<SourceBody> {
        let source = match self {
            Self::Baked(path) => return Err(Error::format(path, "avatar", "is baked already")),
            Self::Recipe(path) => match read_avatar_source(path)? {
                Self::Recipe(_) => {
                    let problem = "a recipe cannot name another one";
                    return Err(Error::format(path, "recipe", problem));
                }
                source => return source.read(),
            },
            Self::Body(source) => source,
        };
        let (mut notes, mut file_vertices) = (Vec::new(), Vec::new());
        let (mut body, recipe) = match &source.from {
            BodyOrigin::Sample { sample, betas } => sample.shaped(betas)?,
            BodyOrigin::Character(character) => {
                let file = character.read()?;
                (notes, file_vertices) = (file.notes, file.file_vertices);
                (file.body, Recipe::default())
            }
            BodyOrigin::Tets { mesh, regions } => {
                let options = CharacterOptions {
                    regions: regions.clone(),
                    ..CharacterOptions::default()
                };
                (read_character(mesh, &options)?.body, limb_recipe())
            }
        };
        if let Some(scale) = source.scale {
            body.scale(scale);
        }
        body.up = source.up.unwrap_or(body.up);
        notes.extend(odd_size(&body));
        Ok(SourceBody {
            body,
            recipe: source.bake.clone().unwrap_or(recipe),
            file_vertices,
            notes,
        })
    }
}

/// A body on its way into a bake.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceBody {
    /// The body.
    pub body: Body,
    /// How it is baked.
    pub recipe: Recipe,
    /// The character file's own vertex that each skin vertex is, where it keeps account of them.
    pub file_vertices: Vec<u32>,
    /// What was decided about its file, a sentence each.
    pub notes: Vec<String>,
}

/// A word about a body that is no person's, hand's or finger's size.
fn odd_size(body: &Body) -> Option<String> {
    /// A finger joint and a tall person, with room on both sides, m.
    const USUAL: std::ops::Range<f64> = 0.02..4.0;
    let (low, high) = body.skin.bounds();
    let largest = (high - low).max_element();
    (!USUAL.contains(&largest)).then(|| {
        format!(
            "{largest:.3} m from end to end: it is baked at that size; a recipe's `scale` says what the file's unit is \
             (0.01 for centimetres)"
        )
    })
}

/// A surface for each bone, from an OBJ file whose objects carry the bones' names.
fn bones_by_name(names: &[String], path: &Path) -> Result<Vec<Surface>> {
    let mut objects = read_closed_obj(path)?;
    let unknown = objects.iter().find(|(name, _)| !names.contains(name));
    if let Some((name, _)) = unknown {
        let problem = format!("the model has no such bone; it has {}", names.join(", "));
        return Err(Error::format(path, name, problem));
    }
    let mut take = |name: &String| {
        let at = objects.iter().position(|o| o.0 == *name);
        at.map(|i| objects.swap_remove(i).1).unwrap_or_default()
    };
    Ok(names.iter().map(&mut take).collect())
}
