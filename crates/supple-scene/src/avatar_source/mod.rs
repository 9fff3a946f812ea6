//! Where an avatar comes from: a baked file, or a body and how it is baked.

mod cache;

pub use cache::load_avatar;

use crate::scene::parse_toml;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use supple::model::Surface;
use supple::{Error, Result};
use supple_bake::Body;
use supple_bake::Recipe;
use supple_files::read_painted;
use supple_files::{CharacterFile, CharacterOptions, FileKind, read_character};
use supple_files::{read_closed_obj, read_tets};
use supple_files::{read_text, read_toml_text};
use supple_samples::{Sample, limb_recipe};

/// An avatar's source: exactly one of `file`, `recipe`, `sample`, `mesh` and `model`, but `mesh` may go with `model`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AvatarSource {
    /// A baked file.
    pub file: Option<PathBuf>,
    /// A TOML file with these same keys.
    pub recipe: Option<PathBuf>,
    /// A body that the crate makes itself.
    pub sample: Option<Sample>,
    /// Tets ([`supple_files::read_tets`]): the soft layer of `model`, or alone a body around one bone, whose rest shape is
    /// that without gravity.
    pub mesh: Option<PathBuf>,
    /// A character file of any kind that [`read_character`] knows.
    pub model: Option<PathBuf>,
    /// Shape parameters of `model`, in the file's order, or of the sample body.
    #[serde(alias = "shape", skip_serializing_if = "Vec::is_empty")]
    pub betas: Vec<f64>,
    /// Closed bone surfaces for `model`: OBJ objects with its bones' names.
    pub bones: Option<PathBuf>,
    /// Maps painted on the skin, by name: `.npy` files, or `.npz` archives with an array of that name, with a number
    /// for each of the file's vertices. A region of handles may name one.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub painted: BTreeMap<String, PathBuf>,
    /// Bones that the regions of `mesh` are, by its labels; a label that is a bone's name needs no entry.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub regions: BTreeMap<String, String>,
    /// The size of the file's unit, m: 0.01 for centimetres. 1 if not given.
    pub scale: Option<f64>,
    /// How it is baked; each sample has its own default.
    pub bake: Option<Recipe>,
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
    source.validate().map_err(|e| e.of_file(path))?;
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
        FileKind::Character(_) => Ok(AvatarSource {
            model: Some(path.into()),
            ..AvatarSource::default()
        }),
        FileKind::Baked => Ok(AvatarSource {
            file: Some(path.into()),
            ..AvatarSource::default()
        }),
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
    let source: AvatarSource = parse_toml(&text, path)?;
    let mut source = AvatarSource {
        file: None,
        recipe: None,
        sample: None,
        mesh: None,
        model: None,
        ..source
    };
    source.resolve(path.parent().unwrap_or(Path::new("")));
    source.model = Some(model.into());
    source.validate().map_err(|e| e.of_file(path))?;
    Ok(source)
}

impl AvatarSource {
    /// The source of a sample with its own recipe.
    pub fn of_sample(sample: Sample) -> Self {
        Self {
            sample: Some(sample),
            ..Self::default()
        }
    }

    /// Checks that there is one source, and that the other keys belong to it.
    pub fn validate(&self) -> Result<()> {
        let given = [
            ("file", self.file.is_some()),
            ("recipe", self.recipe.is_some()),
            ("sample", self.sample.is_some()),
            ("mesh", self.mesh.is_some()),
            ("model", self.model.is_some()),
        ];
        let given: Vec<_> = given.iter().filter(|g| g.1).map(|g| g.0).collect();
        if given.len() != 1 && given != ["mesh", "model"] {
            let problem = format!(
                "needs exactly one of file, recipe, sample, mesh and model, has {}",
                if given.is_empty() {
                    "none".into()
                } else {
                    given.join(", ")
                }
            );
            return Err(Error::invalid("avatar", problem));
        }
        let of_model = [
            ("bones", self.bones.is_some()),
            (
                "betas",
                !self.betas.is_empty() && self.sample != Some(Sample::Body),
            ),
            ("painted", !self.painted.is_empty()),
        ];
        if let (None, Some((key, _))) = (&self.model, of_model.iter().find(|k| k.1)) {
            let problem = "belongs to a model: name one";
            return Err(Error::invalid(format!("avatar.{key}"), problem));
        }
        if self.bake.is_some() && (self.file.is_some() || self.recipe.is_some()) {
            let problem = "what is baked already, or has its own recipe, takes none here";
            return Err(Error::invalid("avatar.bake", problem));
        }
        if self.mesh.is_none() && self.model.is_none() && !self.regions.is_empty() {
            let problem = "belong to a mesh: name one";
            return Err(Error::invalid("avatar.regions", problem));
        }
        if let Some(scale) = self.scale.filter(|s| !(*s > 0.0 && s.is_finite())) {
            let problem = format!("must be positive (m a unit), is {scale}");
            return Err(Error::invalid("avatar.scale", problem));
        }
        let of_bake = |e: Error| e.within("bake");
        (self.bake.iter()).try_for_each(|recipe| recipe.validate().map_err(of_bake))
    }

    /// The recipe's text, as [`parse_avatar_source`] reads it.
    ///
    /// # Errors
    /// [`Error::Invalid`] of what TOML cannot say.
    pub fn to_toml(&self) -> Result<String> {
        toml::to_string_pretty(self)
            .map_err(|e| Error::invalid("recipe", format!("cannot be written as TOML: {e}")))
    }

    /// Asks for the shape `betas` of the model.
    ///
    /// # Errors
    /// [`Error::Invalid`] of a source that has one shape only.
    pub fn set_shape(&mut self, betas: &[f64]) -> Result<()> {
        if self.model.is_none() && self.sample != Some(Sample::Body) {
            let problem = "this body has one shape only; a character file that has shape directions is needed";
            return Err(Error::invalid("shape", problem));
        }
        self.betas = betas.to_vec();
        Ok(())
    }

    /// Puts relative paths into `folder`.
    pub fn resolve(&mut self, folder: &Path) {
        let paths = [
            &mut self.file,
            &mut self.recipe,
            &mut self.mesh,
            &mut self.model,
            &mut self.bones,
        ];
        for path in paths.into_iter().flatten().chain(self.painted.values_mut()) {
            *path = folder.join(&*path);
        }
    }

    /// Every file that the body is read from.
    pub fn files(&self) -> impl Iterator<Item = &Path> {
        let own = [&self.mesh, &self.model, &self.bones].into_iter().flatten();
        own.chain(self.painted.values()).map(PathBuf::as_path)
    }

    /// The body to be baked, and how.
    ///
    /// # Errors
    /// What reading, generating and meshing say; [`Error::Invalid`] of a source that is baked already.
    pub fn body(&self) -> Result<(Body, Recipe)> {
        let SourceBody { body, recipe, .. } = self.read()?;
        Ok((body, recipe))
    }

    /// The body to be baked, how, and what was decided about its file.
    ///
    /// # Errors
    /// As [`AvatarSource::body`].
    pub fn read(&self) -> Result<SourceBody> {
        if let Some(path) = &self.recipe {
            let source = read_avatar_source(path)?;
            if source.recipe.is_some() {
                let problem = "a recipe cannot name another one";
                return Err(Error::format(path, "recipe", problem));
            }
            return source.read();
        }
        let mut notes = Vec::new();
        let (mut body, recipe) = if let Some(sample) = self.sample {
            sample.shaped(&self.betas)?
        } else if let Some(path) = &self.model {
            let mut character = read_character(path, &self.options())?;
            self.complete(&mut character)?;
            notes = character.notes;
            (character.body, Recipe::default())
        } else if let Some(path) = &self.mesh {
            (read_character(path, &self.options())?.body, limb_recipe())
        } else {
            let problem = "a baked file has no body to bake; name a sample, mesh or model";
            return Err(match &self.file {
                Some(path) => Error::format(path, "avatar", "is baked already"),
                None => Error::invalid("avatar", problem),
            });
        };
        if let Some(scale) = self.scale {
            body.scale(scale);
        }
        notes.extend(odd_size(&body));
        Ok(SourceBody {
            body,
            recipe: self.bake.clone().unwrap_or(recipe),
            notes,
        })
    }

    fn options(&self) -> CharacterOptions {
        CharacterOptions {
            betas: self.betas.clone(),
            regions: self.regions.clone(),
        }
    }

    /// Gives a model's body its bone surfaces and painted maps.
    fn complete(&self, character: &mut CharacterFile) -> Result<()> {
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
        Ok(())
    }
}

/// A body on its way into a bake.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceBody {
    /// The body.
    pub body: Body,
    /// How it is baked.
    pub recipe: Recipe,
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
