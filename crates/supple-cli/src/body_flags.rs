//! How a character file is taken: what a recipe would say of it, as flags.

use std::path::{Path, PathBuf};
use supple::model::UpAxis;
use supple::{Error, Result};
use supple_scene::{AvatarSource, avatar_source_of, read_recipe_for};

/// An axis on the command line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Axis {
    X,
    Y,
    Z,
}

impl From<Axis> for UpAxis {
    fn from(axis: Axis) -> Self {
        match axis {
            Axis::X => Self::X,
            Axis::Y => Self::Y,
            Axis::Z => Self::Z,
        }
    }
}

/// How a character file is taken.
#[derive(clap::Args)]
pub struct BodyFlags {
    /// A recipe for FILE: a TOML file whose keys override what the bake would choose.
    #[arg(long)]
    pub recipe: Option<PathBuf>,
    /// Shape parameters of the person, in the model's order: 1.5,-0.3,…
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true)]
    pub shape: Vec<f64>,
    /// The shape of the person that moves in this .npz (AMASS): its betas, as many as the model has.
    #[arg(long, value_name = "FILE", conflicts_with = "shape")]
    pub shape_of: Option<PathBuf>,
    /// The size of the file's unit, m: 0.01 for centimetres.
    #[arg(long, value_name = "METRES")]
    pub scale: Option<f64>,
    /// The axis that points up in the file, in place of what its kind says.
    #[arg(long, value_enum)]
    pub up: Option<Axis>,
    /// Handles that wake where something touches, on the CPU: a press that no recipe foresaw dents as it should. The bake takes
    /// three times as long, a step in contact five times.
    #[arg(long)]
    pub fine_handles: bool,
}

impl BodyFlags {
    /// What `file` stands for, taken as the flags say.
    ///
    /// # Errors
    /// What reading says; of a flag that the file cannot take.
    pub fn source(&self, file: &Path) -> Result<AvatarSource> {
        let mut source = match &self.recipe {
            Some(recipe) => read_recipe_for(recipe, file)?,
            None => avatar_source_of(file)?,
        };
        let of_file = |e: Error| e.of_file(file);
        if !self.shape.is_empty() {
            source.set_shape(&self.shape).map_err(of_file)?;
        }
        if let Some(motion) = &self.shape_of {
            source.set_shape_of(motion).map_err(of_file)?;
        }
        if let Some(scale) = self.scale {
            source.set_scale(scale).map_err(of_file)?;
        }
        if let Some(up) = self.up {
            source.set_up(up.into()).map_err(of_file)?;
        }
        if self.fine_handles {
            source.set_fine_handles().map_err(of_file)?;
        }
        Ok(source)
    }
}
