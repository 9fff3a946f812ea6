//! `supple bake`.

use super::bake_report::print_bake_report;
use super::body_flags::BodyFlags;
use super::make_folder;
use super::terminal::{baking, print, print_json};
use std::path::{Path, PathBuf};
use supple::file::Parts;
use supple::model::Avatar;
use supple::{Error, Result};
use supple_bake::{BakeReport, bake, baked_file};
use supple_pictures::write_bake_pictures;
use supple_scene::{AvatarSource, SourceBody};

/// Arguments of `supple bake`.
#[derive(clap::Args)]
pub struct Arguments {
    /// A character (.npz, .pkl, .glb, .gltf, .vrm, .obj, tets), or a TOML file: a recipe that names one, or a scene.
    file: PathBuf,
    #[command(flatten)]
    body: BodyFlags,
    /// The baked file [default: out/<FILE>.supple].
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Where the pictures go [default: beside the baked file, <FILE>.bake].
    #[arg(long, conflicts_with = "no_pictures")]
    pictures: Option<PathBuf>,
    /// No pictures.
    #[arg(long)]
    no_pictures: bool,
    /// Leave out what no step reads: a file for a game, a fifth of the size; no det F over tets, no full space, no images.
    #[arg(long)]
    without_layer: bool,
    /// Write the bake's figures to stdout as JSON.
    #[arg(long)]
    json: bool,
}

impl Arguments {
    /// Bakes.
    pub fn run(self) -> Result<()> {
        let source = self.body.source(&self.file)?;
        let (avatar, report) = self.bake(&source)?;
        let output = self.output();
        if let Some(folder) = output.parent() {
            make_folder(folder)?;
        }
        let parts = match self.without_layer {
            true => Parts::Step,
            false => Parts::All,
        };
        baked_file(&avatar, Some(&report))?.write(parts, &output)?;
        let pictures = (!self.no_pictures).then(|| match &self.pictures {
            Some(folder) => folder.clone(),
            None => output.with_extension("bake"),
        });
        if let Some(folder) = &pictures {
            make_folder(folder)?;
            write_bake_pictures(&avatar, folder)?;
        }
        if self.json {
            return print_json(&report);
        }
        print_bake_report(&report);
        print(format_args!("\nwritten to {}", output.display()));
        if let Some(folder) = &pictures {
            print(format_args!("pictures in {}", folder.display()));
        }
        Ok(())
    }

    /// The avatar of `source`; an error names the file that is to blame.
    fn bake(&self, source: &AvatarSource) -> Result<(Avatar, BakeReport)> {
        let SourceBody {
            body,
            recipe,
            notes,
            ..
        } = source.read().map_err(|e| name_file(e, &self.file))?;
        let baked = bake(&body, &recipe, &mut baking(&body.name));
        let recipe = self.body.recipe.as_ref().unwrap_or(&self.file);
        let named = |e: Error| match e {
            Error::Invalid { field, problem } => match field.inside("recipe") {
                Some(key) => Error::format(recipe, key.within("bake"), problem),
                None => Error::format(&self.file, field, problem),
            },
            other => name_file(other, &self.file),
        };
        let (avatar, report) = baked.map_err(named)?;
        let notes = notes.into_iter().chain(report.notes).collect();
        Ok((avatar, BakeReport { notes, ..report }))
    }

    fn output(&self) -> PathBuf {
        let default = || {
            let mut name = self.file.file_stem().unwrap_or_default().to_owned();
            name.push(".supple");
            Path::new("out").join(name)
        };
        self.output.clone().unwrap_or_else(default)
    }
}

/// `error` as one of the file at `path`, unless it names one.
fn name_file(error: Error, path: &Path) -> Error {
    match error {
        Error::Invalid { field, problem } => Error::format(path, field, problem),
        Error::Solve { system, problem } => Error::format(path, system, problem),
        Error::NotFinite { quantity } => Error::format(path, quantity, "is not finite"),
        other => other,
    }
}
