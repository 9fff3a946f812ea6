//! `supple view`.

use super::simulate::committed_or_file;
use super::terminal::print;
use std::path::PathBuf;
use supple::{Error, Result};
use supple_samples::Sample;
use supple_view::{Offscreen, Options, Request, open_window};

/// What evaluates the potential.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Backend {
    /// The f64 evaluation.
    Cpu,
    /// The GPU that draws.
    Gpu,
}

/// Arguments of `supple view`.
#[derive(clap::Args)]
pub struct Arguments {
    /// A character (.glb, .gltf, .vrm, .npz, .pkl, .obj, tets), a baked file, a recipe or a scene [default: the sample
    /// hand]. Others may be dropped on the window.
    file: Option<PathBuf>,
    /// A scene, by its file or the name of one that comes with the program; FILE, if named, takes the place of its avatar.
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// A motion to follow in place of the character's own; others may be dropped on the window.
    #[arg(long, value_name = "FILE", conflicts_with = "scene")]
    motion: Option<PathBuf>,
    /// What evaluates the potential.
    #[arg(long, value_enum, default_value = "cpu")]
    backend: Backend,
    /// Write a picture of it instead of opening a window; a software adapter will do.
    #[arg(long, value_name = "FILE.png")]
    picture: Option<PathBuf>,
    /// When the picture is taken, s.
    #[arg(long, default_value_t = 1.0, requires = "picture")]
    seconds: f64,
    /// Where files go that are written from the window.
    #[arg(short, long, default_value = "out/view")]
    output: PathBuf,
    /// Bake with handles that wake where something touches: flesh dents as it should wherever it is touched.
    #[arg(long)]
    fine_handles: bool,
    /// Where bakes are kept.
    #[arg(long, default_value = "out/cache")]
    cache: PathBuf,
}

impl Arguments {
    /// Opens the window, and returns when it is closed.
    pub fn run(self) -> Result<()> {
        let cache = self.cache;
        let options = Options {
            on_gpu: self.backend == Backend::Gpu,
            cache: Some(cache.clone()),
            output: self.output,
            fine_handles: self.fine_handles,
        };
        let request = match (self.scene, self.file) {
            (Some(scene), avatar) => Request::Scene {
                scene: committed_or_file(&scene, &cache)?,
                avatar,
            },
            (None, Some(file)) => Request::File(file),
            (None, None) => Request::Sample(Sample::Hand),
        };
        let request = match self.motion {
            Some(motion) => request.with_motion(motion),
            None => request,
        };
        let Some(path) = &self.picture else {
            return open_window(options, request);
        };
        if !(0.0..=600.0).contains(&self.seconds) {
            let problem = format!("{}; must be within 0 and 600", self.seconds);
            return Err(Error::invalid("--seconds", problem));
        }
        let mut view = Offscreen::open(options, [1180, 760])?;
        view.show(request)?;
        view.run(self.seconds);
        view.picture()?.write_png(path)?;
        print(path.display());
        Ok(())
    }
}
