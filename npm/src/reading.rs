//! From a file's bytes to an avatar: a baked file as it is, a character baked.

use serde::Deserialize;
use std::path::Path;
use supple::model::{Avatar, SoftLayer, UpAxis};
use supple::{Error, Result};
use supple_bake::{PHASES, Recipe, bake};
use supple_files::{CharacterOptions, FileKind, PartNames, parse_character};

/// What may be said of a file. Its keys are those that `index.d.ts` has.
#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields, default)]
pub struct Options {
    /// Names the file in errors; its ending tells what its content does not.
    pub name: String,
    /// The `[bake]` keys of a recipe.
    recipe: Option<Recipe>,
    /// Amounts of the model's shapes.
    betas: Vec<f64>,
    /// Parts that are tissue, or rigid, against what is chosen.
    tissue: Vec<String>,
    rigid: Vec<String>,
    /// m a unit of the file.
    scale: Option<f64>,
    /// The axis that points up in the file.
    up: Option<UpAxis>,
    /// The axis that points up in the world.
    pub world_up: UpAxis,
}

impl Options {
    /// Those of `json`.
    pub fn parse(json: &str) -> Result<Self> {
        serde_json::from_str(json).map_err(|e| {
            let problem = e.to_string();
            // The place in a text that nobody has seen says nothing.
            let problem = problem.split(" at line").next().unwrap_or_default();
            Error::invalid("options", problem)
        })
    }

    /// Whether something is asked for that only a bake does.
    fn asks_for_bake(&self) -> bool {
        self.recipe.is_some()
            || !self.betas.is_empty()
            || !self.tissue.is_empty()
            || !self.rigid.is_empty()
            || self.scale.is_some()
            || self.up.is_some()
    }
}

/// An avatar that a step can be made with, and what is to be known of how it came about.
pub struct Read {
    pub avatar: Avatar,
    pub notes: Vec<String>,
}

/// The avatar in a file's `bytes`; `progress` gets phases done, of all, and the name of the next.
pub fn read(
    bytes: Vec<u8>,
    options: &Options,
    progress: &mut dyn FnMut(usize, usize, &str),
) -> Result<Read> {
    let name = match options.name.is_empty() {
        true => "avatar",
        false => &options.name,
    };
    let path = Path::new(name);
    if FileKind::of_bytes(&bytes, path)? == FileKind::Baked {
        if options.asks_for_bake() {
            let problem = "are for a bake, and this file is baked already; leave recipe, betas, tissue, rigid, scale and \
                           up out, or hand in the character";
            return Err(Error::invalid("options", problem));
        }
        let file = supple_bake::from_bytes(&bytes, path)?;
        let notes = file.report.map(|report| report.notes);
        return Ok(Read::of(file.avatar, notes.unwrap_or_default()));
    }
    let asked = CharacterOptions {
        betas: options.betas.clone(),
        parts: PartNames {
            tissue: options.tissue.clone(),
            rigid: options.rigid.clone(),
        },
        ..CharacterOptions::default()
    };
    let file = parse_character(&bytes, path, &asked)?;
    drop(bytes);
    let mut body = file.body;
    if let Some(scale) = options.scale {
        if !(scale > 0.0 && scale.is_finite()) {
            let problem = format!("must be positive (m a unit), is {scale}");
            return Err(Error::invalid("scale", problem));
        }
        body.scale(scale);
    }
    body.up = options.up.unwrap_or(body.up);
    let recipe = options.recipe.clone().unwrap_or_default();
    let mut tell = |done: usize| {
        let next = PHASES.get(done).copied().unwrap_or_default();
        progress(done, PHASES.len(), next);
    };
    let named = |error: Error| match &error {
        // A recipe is the page's and not the file's.
        Error::Invalid { field, .. } if field.inside("recipe").is_some() => error,
        _ => error.of_file(path),
    };
    let (avatar, report) = bake(&body, &recipe, &mut tell).map_err(named)?;
    let mut notes = file.notes;
    notes.extend(report.notes);
    Ok(Read::of(avatar, notes))
}

impl Read {
    /// Without what no step reads: the mesh behind the cubature, and images that the page has itself.
    fn of(mut avatar: Avatar, notes: Vec<String>) -> Self {
        avatar.layer = SoftLayer::default();
        avatar.appearance = Default::default();
        Self { avatar, notes }
    }
}
