//! The keys of an avatar's source in TOML, any of which may be there.

use super::{AvatarSource, BodyOrigin, BodySource, CharacterSource};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;
use supple::model::UpAxis;
use supple::{Error, Result};
use supple_bake::Recipe;
use supple_files::PartNames;
use supple_samples::{Sample, SampleShape};

/// An avatar's source: exactly one of `file`, `recipe`, `sample`, `mesh` and `model`, but `mesh` may go with `model`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct Keys {
    /// A baked file.
    pub file: Option<PathBuf>,
    /// A TOML file with these same keys.
    pub recipe: Option<PathBuf>,
    /// A body that the crate makes itself.
    pub sample: Option<Sample>,
    /// Tets ([`supple_files::read_tets`]): the soft layer of `model`, or alone a body around one bone, whose rest shape is
    /// that without gravity.
    pub mesh: Option<PathBuf>,
    /// A character file of any kind that [`supple_files::read_character`] knows.
    pub model: Option<PathBuf>,
    /// Shape parameters of `model`, in the file's order, or of the sample body, which has a shape by name too.
    #[serde(alias = "shape", skip_serializing_if = "Shape::is_mean")]
    pub betas: Shape,
    /// A motion (`.npz`, AMASS) whose person's shape the SMPL file `model` takes, in place of `betas`.
    pub betas_of: Option<PathBuf>,
    /// Closed bone surfaces for `model`: OBJ objects with its bones' names.
    pub bones: Option<PathBuf>,
    /// Maps painted on the skin, by name: `.npy` files, or `.npz` archives with an array of that name, with a number
    /// for each of the file's vertices. A region of handles may name one.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub painted: BTreeMap<String, PathBuf>,
    /// Parts of `model` that are tissue besides those that are chosen.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub tissue: Vec<String>,
    /// Parts of `model` that hang on it and that their bones alone move.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rigid: Vec<String>,
    /// Bones that the regions of `mesh` are, by its labels; a label that is a bone's name needs no entry.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub regions: BTreeMap<String, String>,
    /// The size of the file's unit, m: 0.01 for centimetres. 1 if not given.
    pub scale: Option<f64>,
    /// The axis that points up in the body's file: y of glTF, VRM and SMPL's layout, z of OBJ and tets, if not given; a
    /// sample has its own.
    pub up: Option<UpAxis>,
    /// How it is baked; each sample has its own default.
    pub bake: Option<Recipe>,
}

/// A shape: amounts of a model's directions, or the name of one of the sample body's.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a list of amounts, or \"mean\" or \"full\"")]
pub(super) enum Shape {
    /// In the file's order.
    Amounts(Vec<f64>),
    /// Of the sample body.
    Named(SampleShape),
}

impl Default for Shape {
    fn default() -> Self {
        Self::Amounts(Vec::new())
    }
}

impl Shape {
    fn is_mean(&self) -> bool {
        *self == Self::default()
    }

    fn amounts(self) -> Vec<f64> {
        match self {
            Self::Amounts(amounts) => amounts,
            Self::Named(shape) => shape.betas().to_vec(),
        }
    }
}

impl Keys {
    /// Checks that there is one source, and that the other keys belong to it.
    fn validate(&self) -> Result<()> {
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
                !self.betas.is_mean() && self.sample != Some(Sample::Body),
            ),
            ("betas_of", self.betas_of.is_some()),
            ("painted", !self.painted.is_empty()),
            ("tissue", !self.tissue.is_empty()),
            ("rigid", !self.rigid.is_empty()),
        ];
        if let (None, Some((key, _))) = (&self.model, of_model.iter().find(|k| k.1)) {
            let problem = "belongs to a model: name one";
            return Err(Error::invalid(format!("avatar.{key}"), problem));
        }
        if self.model.is_some() && matches!(self.betas, Shape::Named(_)) {
            let problem = "is the sample body's by name; a model's is a list of amounts";
            return Err(Error::invalid("avatar.shape", problem));
        }
        if self.betas_of.is_some() && !self.betas.is_mean() {
            let problem = "is one shape, and betas are another: leave one out";
            return Err(Error::invalid("avatar.betas_of", problem));
        }
        if self.bake.is_some() && (self.file.is_some() || self.recipe.is_some()) {
            let problem = "what is baked already, or has its own recipe, takes none here";
            return Err(Error::invalid("avatar.bake", problem));
        }
        if self.up.is_some() && (self.file.is_some() || self.recipe.is_some()) {
            let problem = "what is baked already, or has its own recipe, has its own up";
            return Err(Error::invalid("avatar.up", problem));
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
}

impl TryFrom<Keys> for AvatarSource {
    type Error = Error;

    fn try_from(keys: Keys) -> Result<Self> {
        keys.validate()?;
        let Keys {
            file,
            recipe,
            sample,
            mesh,
            model,
            betas,
            betas_of,
            bones,
            painted,
            tissue,
            rigid,
            regions,
            scale,
            up,
            bake,
        } = keys;
        let betas = betas.amounts();
        let from = match (file, recipe, sample, model, mesh) {
            (Some(file), ..) => return Ok(Self::Baked(file)),
            (_, Some(recipe), ..) => return Ok(Self::Recipe(recipe)),
            (_, _, Some(sample), ..) => BodyOrigin::Sample { sample, betas },
            (_, _, _, Some(model), mesh) => BodyOrigin::Character(CharacterSource {
                model,
                betas,
                betas_of,
                bones,
                mesh,
                regions,
                painted,
                parts: PartNames { tissue, rigid },
            }),
            (_, _, _, _, Some(mesh)) => BodyOrigin::Tets { mesh, regions },
            _ => return Err(Error::invalid("avatar", "has no source")),
        };
        Ok(Self::Body(Box::new(BodySource {
            from,
            scale,
            up,
            bake,
        })))
    }
}

impl From<AvatarSource> for Keys {
    fn from(source: AvatarSource) -> Self {
        let body = match source {
            AvatarSource::Baked(file) => {
                return Self {
                    file: Some(file),
                    ..Self::default()
                };
            }
            AvatarSource::Recipe(recipe) => {
                return Self {
                    recipe: Some(recipe),
                    ..Self::default()
                };
            }
            AvatarSource::Body(body) => *body,
        };
        let keys = match body.from {
            BodyOrigin::Sample { sample, betas } => Self {
                sample: Some(sample),
                betas: Shape::Amounts(betas),
                ..Self::default()
            },
            BodyOrigin::Character(c) => Self {
                model: Some(c.model),
                betas: Shape::Amounts(c.betas),
                betas_of: c.betas_of,
                bones: c.bones,
                mesh: c.mesh,
                regions: c.regions,
                painted: c.painted,
                tissue: c.parts.tissue,
                rigid: c.parts.rigid,
                ..Self::default()
            },
            BodyOrigin::Tets { mesh, regions } => Self {
                mesh: Some(mesh),
                regions,
                ..Self::default()
            },
        };
        Self {
            scale: body.scale,
            up: body.up,
            bake: body.bake,
            ..keys
        }
    }
}
