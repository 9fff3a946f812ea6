//! `supple bake`.

use super::{print, print_json, progress};
use crate::Result;
use crate::bake::{bake, write_avatar};
use crate::load::avatar_source_of;
use std::path::PathBuf;

/// Arguments of `supple bake`.
#[derive(clap::Args)]
pub struct Arguments {
    /// A TOML file: a recipe (sample, mesh or model, and how to bake it), or a scene.
    recipe: PathBuf,
    /// The baked file [default: the recipe's name with .supple].
    #[arg(short, long)]
    output: Option<PathBuf>,
    /// Write the bake's figures to stdout as JSON.
    #[arg(long)]
    json: bool,
}

impl Arguments {
    /// Bakes.
    pub fn run(self) -> Result<()> {
        let source = avatar_source_of(&self.recipe)?;
        let (body, recipe) = source.body()?;
        let (avatar, report) = bake(&body, &recipe, &mut progress::baking(&body.name))?;
        let output = self
            .output
            .unwrap_or_else(|| self.recipe.with_extension("supple"));
        write_avatar(&avatar, &output)?;
        if self.json {
            return print_json(&report);
        }
        let seconds: f64 = report.seconds.iter().map(|s| s.1).sum();
        print(format_args!(
            "{}: {} handles, {} points, {} tets, {seconds:.1} s",
            output.display(),
            report.handles,
            avatar.cubature.len(),
            report.tets,
        ));
        Ok(())
    }
}
