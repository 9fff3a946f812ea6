//! Where a scene's avatar comes from: a baked file, or a body and how it is baked.

use super::scene::{of_file, parse_toml};
use super::{TetMeshFile, read_closed_obj, read_smpl, read_tet_mesh};
use crate::bake::{CubatureRecipe, HandleRegion, Recipe};
use crate::model::{Body, Surface};
use crate::sample::limb::one_bone_body;
use crate::sample::{Finger, Limb, hand};
use crate::{Error, Result};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// An avatar's source: exactly one of `file`, `recipe`, `sample`, `mesh` and `model`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AvatarSource {
    /// A baked file.
    pub file: Option<PathBuf>,
    /// A TOML file with these same keys.
    pub recipe: Option<PathBuf>,
    /// A body that the crate makes itself.
    pub sample: Option<Sample>,
    /// A tet mesh around one bone ([`read_tet_mesh`]).
    pub mesh: Option<PathBuf>,
    /// A parametric model ([`read_smpl`]).
    pub model: Option<PathBuf>,
    /// Shape parameters of `model`.
    pub betas: Vec<f64>,
    /// Closed bone surfaces for `model`: OBJ objects with its bones' names.
    pub bones: Option<PathBuf>,
    /// How it is baked; each sample has its own default.
    pub bake: Option<Recipe>,
}

/// Bodies that the crate makes itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Sample {
    /// A hand of 16 bones.
    Hand,
    /// A finger of three bones.
    Finger,
    /// The bone press limb, mesh S.
    LimbS,
    /// The bone press limb, mesh M.
    LimbM,
}

/// Reads an avatar's source from the TOML file at `path`; files that it names lie relative to it.
///
/// # Errors
/// [`Error::Io`], [`Error::Format`] with line or key.
pub fn read_avatar_source(path: impl AsRef<Path>) -> Result<AvatarSource> {
    let path = path.as_ref();
    let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, e))?;
    let mut source: AvatarSource = parse_toml(&text, path)?;
    source.validate().map_err(|e| of_file(e, path))?;
    source.resolve(path.parent().unwrap_or(Path::new("")));
    Ok(source)
}

/// Reads an avatar's source from a file of its own or from a scene's `avatar` table.
///
/// # Errors
/// As [`read_avatar_source`] and [`super::read_scene`].
pub fn read_avatar_source_or_scene(path: impl AsRef<Path>) -> Result<AvatarSource> {
    let path = path.as_ref();
    let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, e))?;
    let table: toml::Table = parse_toml(&text, path)?;
    if table.contains_key("avatar") {
        Ok(super::read_scene(path)?.avatar)
    } else {
        read_avatar_source(path)
    }
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
        if given.len() != 1 {
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
        if self.model.is_none() && (self.bones.is_some() || !self.betas.is_empty()) {
            let problem = "bones and betas belong to a model";
            return Err(Error::invalid("avatar", problem));
        }
        if self.bake.is_some() && (self.file.is_some() || self.recipe.is_some()) {
            let problem = "what is baked already, or has its own recipe, takes none here";
            return Err(Error::invalid("avatar.bake", problem));
        }
        self.bake.as_ref().map_or(Ok(()), Recipe::validate)
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
        for path in paths.into_iter().flatten() {
            *path = folder.join(&*path);
        }
    }

    /// The body to be baked, and how.
    ///
    /// # Errors
    /// What reading, generating and meshing say; [`Error::Invalid`] of a source that is baked already.
    pub fn body(&self) -> Result<(Body, Recipe)> {
        if let Some(path) = &self.recipe {
            let source = read_avatar_source(path)?;
            if source.recipe.is_some() {
                return Err(Error::format(
                    path,
                    "recipe",
                    "a recipe cannot name another one",
                ));
            }
            return source.body();
        }
        let (body, recipe) = if let Some(sample) = self.sample {
            sample.body()?
        } else if let Some(path) = &self.mesh {
            let TetMeshFile {
                mesh,
                pinned,
                surface,
            } = read_tet_mesh(path)?;
            (
                one_bone_body(&stem(path), mesh, &pinned, &surface)?,
                limb_recipe(),
            )
        } else if let Some(path) = &self.model {
            (self.model_body(path)?, Recipe::default())
        } else {
            let problem = "a baked file has no body to bake; name a sample, mesh or model";
            return Err(Error::invalid("avatar", problem));
        };
        Ok((body, self.bake.clone().unwrap_or(recipe)))
    }

    /// A model's body, with its bone surfaces if they are given.
    fn model_body(&self, path: &Path) -> Result<Body> {
        let model = read_smpl(path)?;
        let bones = match &self.bones {
            None => Vec::new(),
            Some(path) => bones_by_name(&model.names, path)?,
        };
        Ok(Body::of_model(&stem(path), &model, &self.betas, bones))
    }
}

impl Sample {
    /// The body and its own recipe.
    pub fn body(self) -> Result<(Body, Recipe)> {
        match self {
            Self::LimbS => Ok((Limb::S.body()?, limb_recipe())),
            Self::LimbM => Ok((Limb::M.body()?, limb_recipe())),
            Self::Finger => Ok((Finger::default().body()?, handles(40))),
            Self::Hand => {
                let hand = hand()?;
                let body = Body::of_model("hand", &hand.model, &[], hand.bones);
                Ok((body, hand_recipe(&hand.palmar)))
            }
        }
    }
}

/// The paper's hand: 87 handles over palm and finger pads, 700 cubature points.
fn hand_recipe(palmar: &[bool]) -> Recipe {
    let soft = palmar.iter().zip(0u32..).filter(|(soft, _)| **soft);
    let mut recipe = handles(87);
    recipe.handles[0].vertices = soft.map(|(_, v)| v).collect();
    recipe.cubature = CubatureRecipe {
        points: Some(700),
        ..CubatureRecipe::default()
    };
    recipe
}

/// So many handles all over the skin.
fn handles(count: usize) -> Recipe {
    Recipe {
        handles: vec![HandleRegion {
            count: Some(count),
            ..Default::default()
        }],
        ..Default::default()
    }
}

/// The bone press: its rest shape is that without gravity.
fn limb_recipe() -> Recipe {
    Recipe {
        captured_under_gravity: false,
        ..handles(82)
    }
}

/// File name without folder and extension.
fn stem(path: &Path) -> String {
    path.file_stem()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
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
